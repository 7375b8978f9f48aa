"""Models of other programs in a mechanism: functional mock-up units."""
