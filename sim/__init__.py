"""The simulated world and its exact truth: motion, scene, film, lens and sensor."""
