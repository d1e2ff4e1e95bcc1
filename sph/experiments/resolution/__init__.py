"""What finer particles bring with the scheme for your own slopes: the cost-accuracy study of another scene."""
