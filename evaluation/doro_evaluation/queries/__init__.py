"""The whole system on pairs of recording and instruction (paper, Tables III and IV)."""
