"""What accuracy costs in time: a scene in many ways, the error of each beside its time (`tools/cost_of_accuracy`)."""
