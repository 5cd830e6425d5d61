"""What a plate is asked: its solution under loads, modes, buckling, errors, gradients, failure, hinges."""
