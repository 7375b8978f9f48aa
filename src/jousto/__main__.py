"""``python -m jousto``: the command line."""

from jousto.cli import main

if __name__ == "__main__":
    main()
