"""From a laminate as drawn to rigid bodies and hinges."""
