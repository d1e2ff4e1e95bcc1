"""What finer particles bring with the scheme for one's own slopes: the cost-accuracy study of another scene."""
