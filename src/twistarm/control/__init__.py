"""What moves a real arm: the servo, and the links that carry its commands."""
