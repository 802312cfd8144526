"""Forward selection of effects, backward elimination, probabilities of the candidates.

`screening` projects the error on all effects. `stages` lists the starts of fits, `confirmation` fits and ranks them,
and `credibility` checks their values. `forward` selects effects one at a time; `reselection` and `backward` judge them
beside all others. `evidence`, `priors` and `lack_of_fit` give probabilities.
"""
