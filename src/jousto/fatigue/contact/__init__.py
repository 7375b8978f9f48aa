"""Contact fatigue of rolling bodies."""
