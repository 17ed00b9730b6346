"""Parts of check_studio.py."""
