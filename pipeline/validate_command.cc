#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "data/output_file.h"
#include "ik/assembler.h"
#include "pipeline/command.h"
#include "pipeline/ik_job.h"
#include "pipeline/ik_options.h"
#include "pipeline/option_checks.h"
#include "pipeline/output_check.h"
#include "pipeline/reports.h"
#include "pipeline/version.h"

namespace sinew {
namespace {

struct ValidateCommand {
  IkOptions ik;
  int every = 1;
  double accuracy = AssemblerComparisonOptions{}.accuracy;
  double tolerance = AssemblerComparisonOptions{}.tolerance;
  std::string json;

  int run() const {
    const IkInputs inputs = ik.inputs();
    ik.require_files(inputs);
    check_outputs({json}, input_files(inputs));
    const IkJob job = prepare_ik(inputs);
    std::vector<Warning> warnings;
    report(warnings, job.warnings);
    AssemblerComparisonOptions options;
    options.minimizer = job.options.minimizer;
    options.cold_start = job.options.cold_start;
    options.accuracy = accuracy;
    options.first_frame = job.options.first_frame;
    options.end_frame = job.options.end_frame;
    options.every = every;
    options.tolerance = tolerance;
    options.progress = progress_bar("validation");
    const Comparison comparison =
        compare_with_assembler(job.model, job.tree, job.tracking, job.recording.markers, options);
    if (comparison.stopped) {
      fmt::print(stderr, "stopped; nothing was written\n");
      return kExitFailed;
    }
    print_frames(comparison);
    print_angles(job.model, comparison);
    const bool passed = comparison.worse_frames == 0;
    print_verdict(comparison, passed);
    if (!json.empty()) {
      write_file_atomically(json, json_report(job, inputs, comparison, passed).dump(2) + "\n");
    }
    return passed ? kExitOk : kExitFailed;
  }

  static void print_frames(const Comparison& comparison) {
    fmt::print("{:>8} {:>13} {:>13} {:>9} {:>9} {:>10} {:>9} {:>9} {:>7}\n", "time s", "cost",
               "Assembler", "RMS mm", "Assembler", "violation", "ms", "Assembler", "ratio");
    // A screenful: the rest is in --json.
    const std::size_t step = std::max<std::size_t>(1, comparison.frames.size() / 20);
    for (std::size_t i = 0; i < comparison.frames.size(); ++i) {
      const ComparedFrame& f = comparison.frames[i];
      if (i % step != 0 && !f.worse) continue;
      fmt::print("{:8.3f} {:13.6e} {:13.6e} {:9.3f} {:9.3f} {:10.2e} {:9.4f} {:9.3f} {:7.0f}{}{}\n",
                 f.time, f.cost, f.assembler_cost, 1e3 * f.marker_rms, 1e3 * f.assembler_marker_rms,
                 f.assembler_constraint_error, 1e3 * f.seconds, 1e3 * f.assembler_seconds,
                 f.assembler_seconds / f.seconds, f.worse ? "  Sinew worse" : "",
                 f.assembler_succeeded ? "" : "  Assembler failed");
    }
  }

  static void print_angles(const MusculoskeletalModel& model, const Comparison& comparison) {
    fmt::print("\n{:<24} {:>12} {:>12}\n", "difference", "RMS", "max");
    int of_links = 0;
    for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      if (model.bodies[static_cast<std::size_t>(model.coordinates[c].joint) + 1].virtual_link) {
        ++of_links;
        continue;
      }
      const auto [scale, unit] = unit_of(model.coordinates[c].motion);
      const bool undetermined = std::count(comparison.undetermined.begin(),
                                           comparison.undetermined.end(), static_cast<int>(c)) > 0;
      fmt::print("{:<24} {:12.5f} {:12.5f} {}{}\n", model.coordinates[c].name,
                 scale * comparison.angle_rms[i], scale * comparison.angle_max[i], unit,
                 undetermined ? "  (no marker determines it)" : "");
    }
    if (of_links > 0) {
      fmt::print("and {} coordinates of virtual links, which --json has\n", of_links);
    }
  }

  // A coupled coordinate turns and shifts at once, so its number has no unit of its own.
  static std::pair<double, const char*> unit_of(Coordinate::Motion motion) {
    if (motion == Coordinate::Motion::kRotational) return {180.0 / std::numbers::pi, "deg"};
    if (motion == Coordinate::Motion::kTranslational) return {1e3, "mm"};
    return {1.0, "(turns and shifts)"};
  }

  void print_verdict(const Comparison& comparison, bool passed) const {
    const std::size_t n = comparison.frames.size();
    fmt::print(
        "\nSinew {:.4f} ms a frame; Assembler {:.3f} ms at accuracy {:g}, {:.3f} ms at its "
        "default: ratios {:.0f} and {:.0f}; median ratio of a frame {:.0f}\n",
        1e3 * comparison.seconds / static_cast<double>(n),
        1e3 * comparison.assembler_seconds / static_cast<double>(n), accuracy,
        1e3 * comparison.assembler_default_seconds / static_cast<double>(n),
        comparison.assembler_seconds / comparison.seconds,
        comparison.assembler_default_seconds / comparison.seconds, median_ratio(comparison));
    if (comparison.assembler_failures > 0) {
      fmt::print("The Assembler failed in {} of {} frames\n", comparison.assembler_failures, n);
    }
    if (const auto bad = unconverged(comparison); bad > 0) {
      fmt::print("Sinew did not converge in {} of {} frames, which counts as worse\n", bad, n);
    }
    fmt::print(
        "{}: Sinew is worse than the Assembler in {} of {} frames (largest excess of its cost "
        "{:.2e} of the Assembler's, tolerance {:g})\n",
        passed ? "PASS" : "FAIL", comparison.worse_frames, n, comparison.worst_cost_excess,
        tolerance);
  }

  static std::ptrdiff_t unconverged(const Comparison& comparison) {
    return std::count_if(comparison.frames.begin(), comparison.frames.end(),
                         [](const ComparedFrame& f) { return !converged(f.termination); });
  }

  // Unlike the ratio of the sums, not moved by a frame in which the machine did something else.
  static double median_ratio(const Comparison& comparison) {
    std::vector<double> ratios;
    for (const ComparedFrame& f : comparison.frames) {
      ratios.push_back(f.assembler_seconds / f.seconds);
    }
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
  }

  nlohmann::ordered_json json_report(const IkJob& job, const IkInputs& inputs,
                                     const Comparison& comparison, bool passed) const {
    using Json = nlohmann::ordered_json;
    Json out;
    out["versions"] = component_versions();
    out["inputs"] = input_summary(input_files(inputs));
    out["options"] = {{"method", inputs.method},
                      {"gradient_tolerance", inputs.tolerance},
                      {"every", every},
                      {"accuracy", accuracy},
                      {"tolerance", tolerance}};
    out["passed"] = passed;
    out["worse_frames"] = comparison.worse_frames;
    out["frames_not_converged"] = unconverged(comparison);
    out["assembler_failures"] = comparison.assembler_failures;
    out["worst_cost_excess"] = comparison.worst_cost_excess;
    out["seconds"] = comparison.seconds;
    out["assembler_seconds"] = comparison.assembler_seconds;
    out["assembler_default_accuracy_seconds"] = comparison.assembler_default_seconds;
    out["time_ratio"] = comparison.assembler_seconds / comparison.seconds;
    out["median_time_ratio"] = median_ratio(comparison);
    Json angles = Json::array();
    for (std::size_t c = 0; c < job.model.coordinates.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      angles.push_back(
          {{"coordinate", job.model.coordinates[c].name},
           {"rms", comparison.angle_rms[i]},
           {"max", comparison.angle_max[i]},
           {"determined", std::count(comparison.undetermined.begin(), comparison.undetermined.end(),
                                     static_cast<int>(c)) == 0}});
    }
    out["differences_rad_or_m"] = angles;
    Json frames = Json::array();
    for (const ComparedFrame& f : comparison.frames) {
      frames.push_back({{"time_s", f.time},
                        {"cost", f.cost},
                        {"assembler_cost", f.assembler_cost},
                        {"marker_rms_m", f.marker_rms},
                        {"assembler_marker_rms_m", f.assembler_marker_rms},
                        {"assembler_constraint_error", f.assembler_constraint_error},
                        {"seconds", f.seconds},
                        {"assembler_seconds", f.assembler_seconds},
                        {"termination", to_string(f.termination)},
                        {"assembler_succeeded", f.assembler_succeeded},
                        {"worse", f.worse}});
    }
    out["frames"] = frames;
    out["warnings"] = warning_summary(job.warnings);
    return out;
  }
};

}  // namespace

void add_validate_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ValidateCommand>();
  CLI::App* sub = app.add_subcommand(
      "validate", "Solves the same frames with Simbody's Assembler and compares");
  command->ik.add_to(*sub);
  // Times are of one thread, and what is compared is the end of each frame.
  for (const char* option : {"--threads", "--trace"}) sub->remove_option(sub->get_option(option));
  sub->add_option("--every", command->every, "Compare every Nth frame")
      ->check(a_stride())
      ->capture_default_str();
  sub->add_option("--accuracy", command->accuracy,
                  "The Assembler's accuracy, as its setAccuracy takes it")
      ->check(more_than_zero())
      ->capture_default_str();
  sub->add_option("--tolerance", command->tolerance,
                  "Fail if Sinew's cost exceeds the Assembler's by more than this fraction of it")
      ->check(zero_or_more())
      ->capture_default_str();
  sub->add_option("--json", command->json, "Write the whole comparison to this file");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
