"""Forward selection of effects, backward elimination, probabilities of the candidates."""
