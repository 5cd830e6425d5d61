"""Tables, texts and pictures for people. Nothing is computed from what they show."""
