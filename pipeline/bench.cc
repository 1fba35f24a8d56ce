#include "pipeline/bench.h"

#include <algorithm>
#include <cmath>

#include "pipeline/command.h"

namespace sinew {

std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    names.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

std::vector<Method> methods_in(const std::vector<std::string>& names) {
  if (names == std::vector<std::string>{"all"}) return all_methods();
  std::vector<Method> methods;
  for (const std::string& name : names) methods.push_back(method_from_string(name));
  return methods;
}

std::vector<GradientKind> gradients_for(Method method) {
  if (continues_gradient_sweep(method)) return {GradientKind::kDecomposed};
  return {GradientKind::kJacobian, GradientKind::kDecomposed};
}

const char* to_string(GradientKind gradient) {
  return gradient == GradientKind::kDecomposed ? "dgc" : "jacobian";
}

nlohmann::ordered_json finite_or_null(double value) {
  if (std::isfinite(value)) return value;
  return nullptr;
}

void add_bench_command(CLI::App& app, int& exit_code) {
  CLI::App* bench = app.add_subcommand("bench", "Benchmarks of the solvers");
  bench->require_subcommand(1);
  add_bench_manipulator(*bench, exit_code);
  add_bench_walk(*bench, exit_code);
}

}  // namespace sinew
