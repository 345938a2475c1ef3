"""The checks, one file a criterion: each reads like the lab sheet, asks one question and makes one judgement."""
