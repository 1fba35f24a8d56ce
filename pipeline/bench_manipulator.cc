#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/output_file.h"
#include "ik/manipulator_case.h"
#include "ik/minimizer.h"
#include "ik/newton_raphson.h"
#include "model/simbody_model.h"
#include "pipeline/bench.h"
#include "pipeline/command.h"
#include "pipeline/cpu_time.h"
#include "pipeline/paper_tables.h"
#include "pipeline/version.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

// What one method did on one chain.
struct BenchRow {
  char letter;
  int links, dof;
  std::string method, gradient;
  double seconds = kNaN;
  int iterations = -1, evaluations = -1;
  double final_cost = kNaN, gradient_norm = kNaN;
  std::string termination = {};
};

Json to_json(const BenchRow& row) {
  return {{"case", std::string(1, row.letter)},
          {"links", row.links},
          {"dof", row.dof},
          {"method", row.method},
          {"gradient", row.gradient},
          {"time_ms", finite_or_null(1e3 * row.seconds)},
          {"iterations", row.iterations},
          {"evaluations", row.evaluations},
          {"final_cost", finite_or_null(row.final_cost)},
          {"gradient_norm", finite_or_null(row.gradient_norm)},
          {"termination", row.termination}};
}

// The paper's own methods as the paper ran them; ours until the gradient vanishes to rounding,
// because the paper's e2 would end them while they still gain orders of magnitude.
MinimizerOptions bench_options(Method method, GradientKind gradient, double budget) {
  MinimizerOptions options = paper_options(method);
  options.gradient = gradient;
  options.time_limit = budget;
  const bool second_order = continues_gradient_sweep(method) || method == Method::kGaussNewton;
  if (second_order) options.cost_tolerance = 0.0;
  return options;
}

BenchRow run_minimizer(const ManipulatorCase& chain, char letter, int links, Method method,
                       GradientKind gradient, double budget) {
  BenchRow row{letter, links, chain.tree.unknown_count(), to_string(method), to_string(gradient)};
  Minimizer minimizer(chain.tree, chain.problem, bench_options(method, gradient, budget));
  double total = 0.0;
  for (int repetition = 0; repetition < kMostRepetitions && total < kShortRun; ++repetition) {
    std::vector<double> q = chain.tree.default_q;
    const double start = cpu_seconds();
    const Summary& summary = minimizer.minimize(chain.targets, q);
    const double seconds = cpu_seconds() - start;
    total += seconds;
    if (!(row.seconds <= seconds)) row.seconds = seconds;
    row.iterations = summary.iterations;
    row.evaluations = summary.evaluations;
    row.final_cost = summary.final_cost;
    row.gradient_norm = summary.gradient_norm;
    row.termination = to_string(summary.termination);
  }
  return row;
}

struct BenchManipulatorCommand {
  std::string letter = "A", methods = "all", json;
  std::vector<int> links = {4, 40, 400};
  double budget = 60.0;
  bool growth = false;

  int run() const {
    std::vector<BenchRow> rows;
    for (const int n : links) {
      const ManipulatorCase chain = make_manipulator_case(letter.at(0), n);
      const SimbodyModel simbody(chain.model);  // the chain as Simbody has it, for its bodies
      fmt::print("case {}, {} links, {} degrees of freedom ({} bodies in Simbody)\n", letter, n,
                 chain.tree.unknown_count(), simbody.body_count() - 1);
      print_head();
      for (const BenchRow& row : run_chain(chain, n)) {
        print(row);
        rows.push_back(row);
      }
    }
    Json report;
    if (growth) report["growth"] = measure_growth();
    if (!json.empty()) {
      report["environment"] = component_versions();
      report["rows"] = Json::array();
      for (const BenchRow& row : rows) report["rows"].push_back(to_json(row));
      write_file_atomically(json, report.dump(2) + "\n");
    }
    return kExitOk;
  }

  std::vector<BenchRow> run_chain(const ManipulatorCase& chain, int n) const {
    std::vector<BenchRow> rows;
    std::vector<std::string> names = names_in(methods);
    const bool newton_raphson = std::erase(names, "newton-raphson") > 0 || methods == "all";
    for (const Method method : methods_in(names)) {
      for (const GradientKind gradient : gradients_for(method)) {
        rows.push_back(run_minimizer(chain, letter.at(0), n, method, gradient, budget));
        progress(rows.back());
      }
    }
    if (newton_raphson) add_newton_raphson(chain, n, rows);
    return rows;
  }

  void add_newton_raphson(const ManipulatorCase& chain, int n, std::vector<BenchRow>& rows) const {
    // Its dense steps take (unknowns)³: beyond this many a single one outlasts any budget.
    constexpr int kMostUnknowns = 1500;
    for (const bool line_search : {false, true}) {
      BenchRow row{letter.at(0), n, chain.tree.unknown_count(),
                   line_search ? "newton-raphson-line-search" : "newton-raphson", "jacobian"};
      if (row.dof > kMostUnknowns) {
        row.termination = "too-large";
      } else {
        NewtonRaphson solver(chain.tree, chain.problem, {.line_search = line_search});
        std::vector<double> q = chain.tree.default_q;
        const double start = cpu_seconds();
        const Summary& summary = solver.solve(chain.targets, q);
        row.seconds = cpu_seconds() - start;
        row.iterations = summary.iterations;
        row.evaluations = summary.evaluations;
        row.final_cost = summary.final_cost;
        row.gradient_norm = summary.gradient_norm;
        row.termination = to_string(summary.termination);
      }
      rows.push_back(row);
    }
  }

  static void progress(const BenchRow& row) {
    if (row.seconds > 2.0)
      fmt::print(stderr, "{} ({}): {:.1f} s\n", row.method, row.gradient, row.seconds);
  }

  static void print_head() {
    fmt::print(
        "  {:<24} {:<8} {:>11} {:>10} {:>11} {:>10} {:>10}  {:<15} | {:>10} {:>10} {:>9} {:>8}\n",
        "method", "gradient", "time ms", "iterations", "evaluations", "final cost", "|g|",
        "ended by", "paper ms", "iterations", "cost", "ratio");
  }

  void print(const BenchRow& row) const {
    fmt::print("  {:<24} {:<8} {:11.3f} {:10} {:11} {:10.2e} {:10.1e}  {:<15} |", row.method,
               row.gradient, 1e3 * row.seconds, row.iterations, row.evaluations, row.final_cost,
               row.gradient_norm, row.termination);
    const PaperRow* paper =
        find_paper_row(row.letter, row.method.c_str(), row.gradient == "dgc", row.dof);
    if (paper != nullptr) {
      fmt::print(" {:10.1f} {:10} {:9.1e} {:8.1f}", paper->time_ms, paper->iterations,
                 paper->final_cost, paper->time_ms / (1e3 * row.seconds));
    }
    fmt::print("\n");
  }

  // Time of an iteration of the articulated methods against the number of links, and the exponent
  // of the power law through it.
  Json measure_growth() const {
    Json report = Json::array();
    fmt::print("time of an iteration against links, case {}\n", letter);
    for (const Method method : {Method::kArticulatedGaussNewton, Method::kArticulatedNewton}) {
      std::vector<double> x, y;
      for (const int n : {40, 80, 160, 400, 800, 1600, 4000}) {
        const ManipulatorCase chain = make_manipulator_case(letter.at(0), n);
        MinimizerOptions options = bench_options(method, GradientKind::kDecomposed, budget);
        options.max_iterations = 20;
        Minimizer minimizer(chain.tree, chain.problem, options);
        double best = HUGE_VAL;
        for (int repetition = 0; repetition < 5; ++repetition) {
          std::vector<double> q = chain.tree.default_q;
          const Summary& summary = minimizer.minimize(chain.targets, q);
          best = std::min(best, summary.seconds / summary.evaluations);
        }
        fmt::print("  {:<24} {:>5} links {:10.2f} us\n", to_string(method), n, 1e6 * best);
        x.push_back(std::log(n));
        y.push_back(std::log(best));
        report.push_back(
            {{"method", to_string(method)}, {"links", n}, {"us_per_iteration", 1e6 * best}});
      }
      fmt::print("  {:<24} grows as links^{:.3f}\n", to_string(method), slope(x, y));
      report.push_back({{"method", to_string(method)}, {"exponent", slope(x, y)}});
    }
    return report;
  }

  // Of the least-squares line through the points.
  static double slope(const std::vector<double>& x, const std::vector<double>& y) {
    const auto n = static_cast<double>(x.size());
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sx += x[i];
      sy += y[i];
      sxx += x[i] * x[i];
      sxy += x[i] * y[i];
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
  }
};

}  // namespace

void add_bench_manipulator(CLI::App& bench, int& exit_code) {
  auto command = std::make_shared<BenchManipulatorCommand>();
  CLI::App* sub = bench.add_subcommand(
      "manipulator",
      "The chain of spherical joints of Ayusawa & Nakamura 2012, beside the paper's tables I-IV");
  sub->add_option("--case", command->letter,
                  "A (end-effector only) or B (every second link as well)")
      ->check(CLI::IsMember({"A", "B"}))
      ->capture_default_str();
  sub->add_option("--links", command->links, "Numbers of links, 3 degrees of freedom each")
      ->delimiter(',')
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--methods", command->methods,
                  "all, or names separated by commas: " + method_names() + ", newton-raphson")
      ->capture_default_str();
  sub->add_option("--budget", command->budget, "Cut each run off after this time [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_flag("--growth", command->growth,
                "Also time an iteration of the articulated methods from 40 to 4000 links");
  sub->add_option("--json", command->json, "Write all rows to this file");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
