"""An axis with its controllers and sensors as records of arrays, and the stick-slip modes of its joints."""
