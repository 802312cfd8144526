"""Results: parameters with residuals, status and notes, and their application to other logs."""
