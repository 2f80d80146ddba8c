"""How often the report's claims are right: whole studies are drawn from what bench and people scatter by."""
