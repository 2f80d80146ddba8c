"""The package for a manuscript: numbers with their lineage, a document to proof, the archive; and its verification."""
