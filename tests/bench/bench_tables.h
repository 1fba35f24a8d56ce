#pragma once

namespace sinew {

/// One gradient of the cost by decomposition, by explicit Jacobians and by Simbody's operator.
/// batch_seconds: how long each is run in a round.
void print_gradient_times(double batch_seconds);

/// One frame by every method, on the published trials. frames: at most so many of each.
void print_frame_times(int frames);

/// One frame by Gauss-Newton and by Simbody's Assembler, on the published trials.
void print_assembler_times(int frames);

/// A direction by sparse factorization and by preconditioned conjugate gradients.
void print_direction_times(double batch_seconds);

}  // namespace sinew
