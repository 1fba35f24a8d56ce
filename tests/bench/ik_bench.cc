// Times of gradients and of frames, as tables. Run it from the project's root; with `quick` it
// takes seconds instead of minutes.

#include <fmt/format.h>

#include <cstring>

#include "tests/bench/bench_tables.h"

int main(int argc, char** argv) {
  const bool quick = argc == 2 && std::strcmp(argv[1], "quick") == 0;
  if (argc > 1 && !quick) {
    fmt::print(stderr, "usage: ik_bench [quick]\n");
    return 2;
  }
  sinew::print_gradient_times(quick ? 0.002 : 0.05);
  sinew::print_direction_times(quick ? 0.02 : 0.2);
  sinew::print_frame_times(quick ? 5 : 40);
  sinew::print_assembler_times(quick ? 5 : 40);
  fmt::print(
      "Times are what the process computed, not what passed on the clock.\n\n"
      "What this cannot prove: ratios hold for these models, on this machine, with these compiler\n"
      "flags. Other programs spoil caches: repeat the run before you quote it. Simbody's operator\n"
      "and Assembler serve any system, quaternions and constraints included, and keep more than "
      "is\n"
      "needed here; its custom joints call virtual functions where ours have polynomials. The\n"
      "Assembler's times are those of OpenSim's solver, not of OpenSim's tool. Methods that do "
      "not\n"
      "converge within 2000 iterations are slower by more than the printed ratio.\n");
  return 0;
}
