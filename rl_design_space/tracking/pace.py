"""What a tracker process is told: nobody learns, so it need not hold back; or somebody does."""

HURRY, CALM = "hurry", "calm"
