"""Forces: loads, springs, friction, moving loads, loads along beams."""
