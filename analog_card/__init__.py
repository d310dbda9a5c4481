"""The analogue sliding-mode control card: what is soldered, what is turned, what it does."""
