"""What more a plate is asked: modes, buckling, errors, gradients, failure, hinges."""
