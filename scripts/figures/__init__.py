"""The figures of the documents, a module a document: each maps names of figures to functions that measure and return Markdown."""
