// Counts allocations by standing in for malloc, which Eigen and operator new both call. A sanitizer
// has a malloc of its own, and hooks to count its calls.

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>

#include "ik/minimizer.h"
#include "tests/ik/methods.h"
#include "tests/ik/walker.h"

#if defined(__SANITIZE_ADDRESS__)
#include "tests/data/sanitizer_hooks.h"
#endif

namespace {

thread_local bool counting = false;
thread_local long allocations = 0;

void count() {
  if (counting) ++allocations;
}

}  // namespace

#if defined(__SANITIZE_ADDRESS__)

namespace {

const int hooked = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { count(); }, [](const volatile void*) {});

}  // namespace

#else

// glibc's own names for what its malloc family does.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) noexcept {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t items, std::size_t size) noexcept {
  count();
  return __libc_calloc(items, size);
}
void* realloc(void* old, std::size_t size) noexcept {
  count();
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
}

#endif

namespace sinew {
namespace {

template <typename Action>
long allocations_in(const Action& action) {
  allocations = 0;
  counting = true;
  // The compiler knows that malloc itself reads none of these, not that somebody listens to it.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  action();
  std::atomic_signal_fence(std::memory_order_seq_cst);
  counting = false;
  return allocations;
}

TEST(Allocations, AreCounted) {
  void* volatile sink = nullptr;
  EXPECT_EQ(allocations_in([&] { sink = std::malloc(100); }), 1);
  std::free(sink);
  EXPECT_EQ(allocations_in([&] { sink = new double; }), 1);
  delete static_cast<double*>(sink);
  Eigen::VectorXd v;
  EXPECT_EQ(allocations_in([&] { v.resize(100); }), 1);
  EXPECT_EQ(allocations_in([&] { v.setZero(); }), 0);
}

class AllocationsOf : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Minimizer, AllocationsOf, testing::ValuesIn(kEveryMethod), test_name_of);

TEST_P(AllocationsOf, MinimizingAFrameAreNone) {
  Walker walker;
  clamp(walker.model.coordinates[0], -0.05, 0.05);  // a bound that comes and goes
  walker.compile();
  for (int b = 1; b < walker.tree.link_count(); ++b) {  // every kind of residual
    walker.problem.orientations.push_back({b});
    walker.problem.distances.push_back({0, b, {1, 0, 0}, {0, 0.1, 0}, 0.1});
    walker.problem.wires.push_back(
        {static_cast<int>(walker.problem.wire_points.size()), 3, 0.9, 0.1});
    walker.problem.wire_points.push_back({0, {1, 0, 0}});
    walker.problem.wire_points.push_back({1, {0, 0.2, 0}});
    walker.problem.wire_points.push_back({b, {0, 0.1, 0}});
  }
  walker.problem.coordinates = {{3, 3, 0.1}};
  walker.problem.coincidences = {{2, 5, {0, 0.1, 0}, {0.1, 0, 0}, 0.1}};
  walker.problem.alignments = {{3, 6}};
  for (const GradientKind gradient : {GradientKind::kDecomposed, GradientKind::kJacobian}) {
    MinimizerOptions options;
    options.method = GetParam();
    options.gradient = gradient;
    options.max_iterations = 200;
    Minimizer minimizer(walker.tree, walker.problem, options);
    std::vector<double> q = walker.tree.default_q;
    int iterations = 0;
    for (unsigned frame = 0; frame < 5; ++frame) {
      IkTargets targets = walker.targets_at(walker.pose(frame, 0.3));
      for (std::size_t i = 0; i < targets.orientations.size(); ++i) {
        targets.orientations[i].setIdentity();
        targets.distances[i] = 0.9;
      }
      targets.coordinates[0] = 0.1;
      EXPECT_EQ(allocations_in([&] { iterations += minimizer.minimize(targets, q).iterations; }), 0)
          << "frame " << frame;
    }
    EXPECT_GE(iterations, 15);
  }
}

}  // namespace
}  // namespace sinew
