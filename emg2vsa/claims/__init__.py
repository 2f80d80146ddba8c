"""What a study claims: each claim is an estimate with its interval over the right unit of error, and its verdict."""
