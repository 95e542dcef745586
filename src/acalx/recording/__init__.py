"""What a run leaves: its directory."""

from acalx.recording.run_directory import RunDirectory, versions

__all__ = ["RunDirectory", "versions"]
