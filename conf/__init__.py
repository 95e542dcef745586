"""The Hydra configurations of acalx: a folder a group, a YAML an option."""
