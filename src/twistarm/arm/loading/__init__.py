"""Loading: from a description and the files beside it to a proven arm; arms built joint by joint; a first arm.toml."""
