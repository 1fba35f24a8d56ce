#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data/input_error.h"

namespace sinew {

/// One thing that a run chose: what, why, how sure, and what chooses otherwise.
struct Decision {
  std::string name;                     // "up", "contact 1.2"
  nlohmann::ordered_json value, found;  // what is used; what the recording says, null: nothing
  std::string why;
  std::optional<double> confidence;  // 0 to 1; none where nothing is guessed
  std::string by;                    // "recording", "default", "option" or "decisions.json"
  std::string option;                // "--up"
  // What a number may be, whatever an edited file says.
  enum class Range { kAny, kAboveZero, kZeroOrMore, kShare, kCutoff };
  Range range = Range::kAny;
};

/// All decisions of a run, in order: each is printed as it falls, and all are written to
/// decisions.json, from which the run can be repeated. A value that the user edits there holds as
/// one given by its option does.
class DecisionLog {
 public:
  DecisionLog() = default;
  /// Of an earlier run. Throws InputError for a file that is none.
  explicit DecisionLog(const std::filesystem::path& replayed);

  /// What the command line says; `now`: the current one, else that of the run that is repeated.
  void say(const std::string& name, nlohmann::ordered_json value, bool now);

  /// Whether the command line or an edited file says something other than nothing, so that finding
  /// it in the recording may fail.
  bool said(const std::string& name) const;

  /// Settles a decision, prints it in a line and returns the value to use: the current command
  /// line's, else that of the run that is repeated, else what was found. A `found` of null without
  /// any of these is returned as null. `by_default`: `found` is no finding but a default.
  nlohmann::ordered_json settle(Decision decision, bool by_default = false);

  /// The same with types; a value of another type in decisions.json, and a number out of the
  /// decision's range, is an InputError naming it.
  std::string settle_text(Decision decision, bool by_default = false);
  std::vector<std::string> settle_texts(Decision decision);
  double settle_number(Decision decision, bool by_default = false);
  /// The same, or nothing where the value is null.
  std::optional<double> settle_number_or_none(Decision decision);
  bool settle_flag(Decision decision, bool by_default = false);

  const std::vector<Decision>& decisions() const { return decisions_; }
  nlohmann::ordered_json to_json() const;

  /// Options of the run that is repeated, as they stood on its command line.
  const std::map<std::string, std::vector<std::string>>& options() const { return options_; }
  /// Inputs of that run by what they are; paths are resolved against the file's folder.
  const std::map<std::string, std::filesystem::path>& inputs() const { return inputs_; }
  /// Names the inputs that have changed since.
  std::vector<Warning> changed_inputs() const;

 private:
  double number_in_range(const nlohmann::ordered_json& value) const;  // of the last decision
  [[noreturn]] void wrong_type(const Decision& decision, const char* expected) const;

  std::string path_;
  std::map<std::string, nlohmann::ordered_json> said_now_, said_before_, replayed_;
  std::map<std::string, std::vector<std::string>> options_;
  std::map<std::string, std::filesystem::path> inputs_;
  std::map<std::string, std::string> hashes_;
  std::vector<Decision> decisions_;
};

/// A line of a decision: `up: z (the reaction forces on the plates, 98 % sure) [--up]`.
std::string describe(const Decision& decision);

}  // namespace sinew
