"""What is asked: study files, the cases they unfold into, and the claims they are held to."""
