"""Pages: documents for people, such as the certificate of a part."""
