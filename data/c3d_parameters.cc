#include "data/c3d_parameters.h"

#include <algorithm>
#include <array>

#include "data/text.h"

namespace sinew {
namespace {

// NUL padding is as common as blanks.
std::string trimmed(std::string_view text) {
  text = text.substr(0, std::min(text.size(), text.find('\0')));
  return std::string(text::trim(text));
}

// NAME, NAME2, NAME3, ... as far as they follow each other.
template <typename Visit>
void visit_all(const C3dGroups& groups, std::string_view group, std::string_view name,
               const Visit& visit) {
  const C3dGroup* found = find_group(groups, group);
  if (found == nullptr) return;
  for (int i = 1;; ++i) {
    const std::string suffix = i == 1 ? "" : std::to_string(i);
    const C3dParameter* parameter = found->find(std::string(name) + suffix);
    if (parameter == nullptr) return;
    visit(*parameter);
  }
}

C3dGroup& find_or_add(C3dGroups& groups, std::string_view name) {
  if (const C3dGroup* found = find_group(groups, name)) {
    return groups[static_cast<std::size_t>(found - groups.data())];
  }
  int id = 1;
  const auto taken = [&](const C3dGroup& group) { return group.id == id; };
  while (std::any_of(groups.begin(), groups.end(), taken)) ++id;
  groups.push_back({.id = id, .name = std::string(name), .description = "", .parameters = {}});
  return groups.back();
}

bool is_continuation(std::string_view name, std::string_view of, bool and_first) {
  if (name.size() < of.size() || !text::equals_ignoring_case(name.substr(0, of.size()), of)) {
    return false;
  }
  const std::string_view rest = name.substr(of.size());
  if (rest.empty()) return and_first;
  return rest.find_first_not_of("0123456789") == rest.npos;
}

}  // namespace

std::vector<double> C3dParameter::numbers(bool as_unsigned) const {
  std::vector<double> result;
  if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&values)) {
    result.assign(bytes->begin(), bytes->end());
  } else if (const auto* integers = std::get_if<std::vector<std::int16_t>>(&values)) {
    for (const std::int16_t value : *integers) {
      result.push_back(as_unsigned ? static_cast<std::uint16_t>(value) : value);
    }
  } else if (const auto* reals = std::get_if<std::vector<float>>(&values)) {
    result.assign(reals->begin(), reals->end());
  }
  return result;
}

std::optional<double> C3dParameter::number(bool as_unsigned) const {
  const std::vector<double> all = numbers(as_unsigned);
  return all.empty() ? std::nullopt : std::optional<double>(all.front());
}

std::vector<std::string> C3dParameter::texts() const {
  const auto* characters = std::get_if<std::string>(&values);
  if (characters == nullptr) return {};
  if (dimensions.size() < 2) return {trimmed(*characters)};
  std::vector<std::string> result;
  const auto width = static_cast<std::size_t>(dimensions.front());
  for (std::size_t at = 0; width > 0 && at + width <= characters->size(); at += width) {
    result.push_back(trimmed(std::string_view(*characters).substr(at, width)));
  }
  return result;
}

C3dParameter C3dParameter::of_integers(std::string name, std::vector<int> dimensions,
                                       std::vector<std::int16_t> values) {
  return {.name = std::move(name),
          .description = "",
          .dimensions = std::move(dimensions),
          .values = std::move(values)};
}

C3dParameter C3dParameter::of_reals(std::string name, std::vector<int> dimensions,
                                    std::vector<float> values) {
  return {.name = std::move(name),
          .description = "",
          .dimensions = std::move(dimensions),
          .values = std::move(values)};
}

C3dParameter C3dParameter::of_text(std::string name, const std::string& text) {
  return {.name = std::move(name),
          .description = "",
          .dimensions = {static_cast<int>(std::min<std::size_t>(text.size(), 255))},
          .values = text.substr(0, 255)};
}

C3dParameter C3dParameter::of_texts(std::string name, const std::vector<std::string>& texts) {
  std::size_t width = 1;
  for (const std::string& text : texts) width = std::max(width, text.size());
  width = std::min<std::size_t>(width, 255);
  std::string all;
  for (std::string text : texts) {
    text.resize(width, ' ');
    all += text;
  }
  return {.name = std::move(name),
          .description = "",
          .dimensions = {static_cast<int>(width), static_cast<int>(texts.size())},
          .values = std::move(all)};
}

const C3dParameter* C3dGroup::find(std::string_view wanted) const {
  for (const C3dParameter& parameter : parameters) {
    if (text::equals_ignoring_case(parameter.name, wanted)) return &parameter;
  }
  return nullptr;
}

const C3dGroup* find_group(const C3dGroups& groups, std::string_view name) {
  static constexpr std::array<std::string_view, 3> kForcePlatform = {
      "FORCE_PLATFORM", "FORCE_PLATFORMS", "FORCE_PLATEFORM"};
  for (const C3dGroup& group : groups) {
    if (text::equals_ignoring_case(group.name, name)) return &group;
  }
  if (name != kForcePlatform[0]) return nullptr;
  for (const C3dGroup& group : groups) {
    for (const std::string_view alias : kForcePlatform) {
      if (text::equals_ignoring_case(group.name, alias)) return &group;
    }
  }
  return nullptr;
}

const C3dParameter* find_parameter(const C3dGroups& groups, std::string_view group,
                                   std::string_view name) {
  const C3dGroup* found = find_group(groups, group);
  return found == nullptr ? nullptr : found->find(name);
}

std::optional<double> find_number(const C3dGroups& groups, std::string_view group,
                                  std::string_view name, bool as_unsigned) {
  const C3dParameter* found = find_parameter(groups, group, name);
  return found == nullptr ? std::nullopt : found->number(as_unsigned);
}

std::vector<double> find_numbers(const C3dGroups& groups, std::string_view group,
                                 std::string_view name, bool as_unsigned) {
  std::vector<double> all;
  visit_all(groups, group, name, [&](const C3dParameter& parameter) {
    const std::vector<double> more = parameter.numbers(as_unsigned);
    all.insert(all.end(), more.begin(), more.end());
  });
  return all;
}

std::vector<std::string> find_texts(const C3dGroups& groups, std::string_view group,
                                    std::string_view name) {
  std::vector<std::string> all;
  visit_all(groups, group, name, [&](const C3dParameter& parameter) {
    for (std::string& text : parameter.texts()) all.push_back(std::move(text));
  });
  return all;
}

void set_parameter(C3dGroups& groups, std::string_view group, C3dParameter parameter) {
  C3dGroup& into = find_or_add(groups, group);
  for (C3dParameter& old : into.parameters) {
    if (!text::equals_ignoring_case(old.name, parameter.name)) continue;
    parameter.description = std::move(old.description);
    parameter.locked = old.locked;
    old = std::move(parameter);
    return;
  }
  into.parameters.push_back(std::move(parameter));
}

void remove_parameters(C3dGroups& groups, std::string_view group, std::string_view name,
                       bool and_first) {
  const C3dGroup* found = find_group(groups, group);
  if (found == nullptr) return;
  std::erase_if(groups[static_cast<std::size_t>(found - groups.data())].parameters,
                [&](const C3dParameter& p) { return is_continuation(p.name, name, and_first); });
}

}  // namespace sinew
