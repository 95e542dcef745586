"""What optimizers share: descents, exchange, starts, agreement, fronts."""
