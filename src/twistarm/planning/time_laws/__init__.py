"""Time laws along paths, and motions along straight lines in closed form, as fast as limits allow."""
