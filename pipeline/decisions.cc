#include "pipeline/decisions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/input_file.h"
#include "data/setup_fields.h"
#include "data/text.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

std::string text_of(const Json& value) {
  if (value.is_null()) return "nothing";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_array()) {
    std::string list;
    for (const Json& item : value) list += (list.empty() ? "" : ", ") + text_of(item);
    return list;
  }
  if (value.is_object()) return fmt::format("{} entries", value.size());
  return value.dump();
}

}  // namespace

DecisionLog::DecisionLog(const std::filesystem::path& replayed) : path_(replayed.string()) {
  const std::string content = text::read_text_file(replayed, "a file of decisions");
  try {
    const Json json = Json::parse(content);
    if (json.at("version").get<int>() != kVersion) throw std::invalid_argument("version");
    for (const Json& decision : json.at("decisions")) {
      // What was taken as it was found is found again, so that it follows what is edited.
      if (decision.at("value") == decision.at("found") && decision.at("by") != "option") continue;
      replayed_[decision.at("name").get<std::string>()] = decision.at("value");
    }
    for (const auto& [option, values] : json.at("options").items()) {
      options_[option] = values.get<std::vector<std::string>>();
    }
    for (const auto& [role, file] : json.at("inputs").items()) {
      inputs_[role] = resolve_setup_path(file.at("path").get<std::string>(), replayed);
      hashes_[role] = file.at("sha256").get<std::string>();
    }
  } catch (const std::exception& error) {
    throw InputError({path_}, {fmt::format("is no file of decisions: {}", error.what()),
                               fmt::format("JSON with version {}, inputs, options and decisions, "
                                           "as `sinew run --c3d` writes it",
                                           kVersion),
                               "", "Correct what was edited, or run again without it."});
  }
}

void DecisionLog::say(const std::string& name, Json value, bool now) {
  (now ? said_now_ : said_before_)[name] = std::move(value);
}

bool DecisionLog::said(const std::string& name) const {
  if (said_now_.contains(name) || said_before_.contains(name)) return true;
  const auto replayed = replayed_.find(name);
  return replayed != replayed_.end() && !replayed->second.is_null();
}

Json DecisionLog::settle(Decision decision, bool by_default) {
  decision.by = by_default ? "default" : "recording";
  decision.value = decision.found;
  const auto before = said_before_.find(decision.name), now = said_now_.find(decision.name);
  if (before != said_before_.end()) {
    decision.value = before->second;
    decision.by = "option";
  }
  const auto replayed = replayed_.find(decision.name);
  if (replayed != replayed_.end() && replayed->second != decision.value) {
    decision.value = replayed->second;
    decision.by = "decisions.json";
  }
  if (now != said_now_.end()) {
    decision.value = now->second;
    decision.by = "option";
  }
  fmt::print("{}\n", describe(decision));
  decisions_.push_back(decision);
  return decision.value;
}

void DecisionLog::wrong_type(const Decision& decision, const char* expected) const {
  throw InputError({path_.empty() ? decision.option : path_},
                   {fmt::format("the value of decision '{}' is of the wrong kind", decision.name),
                    expected, decision.value.dump(), "Correct the value."});
}

std::string DecisionLog::settle_text(Decision decision, bool by_default) {
  const Json value = settle(std::move(decision), by_default);
  if (!value.is_string()) wrong_type(decisions_.back(), "a text");
  return value.get<std::string>();
}

std::vector<std::string> DecisionLog::settle_texts(Decision decision) {
  const Json value = settle(std::move(decision));
  const bool texts = value.is_array() && std::all_of(value.begin(), value.end(),
                                                     [](const Json& v) { return v.is_string(); });
  if (!texts) wrong_type(decisions_.back(), "a list of texts");
  return value.get<std::vector<std::string>>();
}

double DecisionLog::settle_number(Decision decision, bool by_default) {
  return number_in_range(settle(std::move(decision), by_default));
}

std::optional<double> DecisionLog::settle_number_or_none(Decision decision) {
  const Json value = settle(std::move(decision));
  if (value.is_null()) return {};
  return number_in_range(value);
}

double DecisionLog::number_in_range(const Json& value) const {
  using Range = Decision::Range;
  const Decision& decision = decisions_.back();
  if (!value.is_number()) wrong_type(decision, "a number");
  const double number = value.get<double>();
  const auto require = [&](bool fine, const char* expected) {
    if (fine && std::isfinite(number)) return;
    throw InputError({path_.empty() ? decision.option : path_},
                     {fmt::format("the value of decision '{}' is out of its range", decision.name),
                      expected, value.dump(), "Correct the value."});
  };
  switch (decision.range) {
    case Range::kAny:
      require(true, "a finite number");
      break;
    case Range::kAboveZero:
      require(number > 0.0, "a number above 0");
      break;
    case Range::kZeroOrMore:
      require(number >= 0.0, "0 or more");
      break;
    case Range::kShare:
      require(number >= 0.0 && number <= 1.0, "a number from 0 to 1");
      break;
    case Range::kCutoff:
      require(number != 0.0, "a frequency above 0 Hz, or a negative number for no filter");
      break;
  }
  return number;
}

bool DecisionLog::settle_flag(Decision decision, bool by_default) {
  const Json value = settle(std::move(decision), by_default);
  if (!value.is_boolean()) wrong_type(decisions_.back(), "true or false");
  return value.get<bool>();
}

Json DecisionLog::to_json() const {
  Json list = Json::array();
  for (const Decision& d : decisions_) {
    Json entry = {{"name", d.name}, {"value", d.value}, {"found", d.found}, {"why", d.why}};
    entry["confidence"] = d.confidence ? Json(*d.confidence) : Json();
    entry["by"] = d.by;
    entry["option"] = d.option;
    list.push_back(entry);
  }
  return {{"about",
           "Decisions of a run of sinew. Edit a value and repeat the run with `sinew run "
           "--decisions FILE`; `found` is what the recording said, `option` what says otherwise on "
           "the command line."},
          {"version", kVersion},
          {"decisions", list}};
}

std::vector<Warning> DecisionLog::changed_inputs() const {
  std::vector<Warning> warnings;
  for (const auto& [role, path] : inputs_) {
    std::error_code error;
    if (!std::filesystem::exists(path, error) || sha256_of_file(path) == hashes_.at(role)) continue;
    warnings.push_back({{path.string()}, fmt::format("has changed since {} was written", path_)});
  }
  return warnings;
}

std::string describe(const Decision& decision) {
  std::string why = decision.why;
  if (decision.by == "option" || decision.by == "decisions.json") {
    why = decision.by == "option" ? "said by " + decision.option : "as decisions.json says";
    if (!decision.found.is_null() && decision.found != decision.value) {
      why += fmt::format("; found {}{}{}", text_of(decision.found),
                         decision.why.empty() ? "" : ": ", decision.why);
    }
  } else if (decision.confidence) {
    why += fmt::format(", {:.0f} % sure", 100.0 * *decision.confidence);
  }
  return fmt::format("{}: {} ({}) [{}]", decision.name, text_of(decision.value), why,
                     decision.option);
}

}  // namespace sinew
