#include "data/setup_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "data/text.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// `C:\...`, `C:/...` and `\\server\...` name nothing here, so they are kept for messages.
bool is_windows_path(const std::string& text) {
  const bool drive = text.size() >= 3 && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
                     text[1] == ':' && (text[2] == '\\' || text[2] == '/');
  return drive || text.starts_with("\\\\");
}

}  // namespace

fs::path resolve_setup_path(const std::string& text, const fs::path& setup_path) {
  if (text.empty() || is_windows_path(text)) return text;
  std::string portable = text;
  std::replace(portable.begin(), portable.end(), '\\', '/');
  const fs::path path = (fs::absolute(setup_path).parent_path() / portable).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

pugi::xml_node find_tool(const XmlFile& xml, std::initializer_list<const char*> names) {
  const auto matches = [&](pugi::xml_node node) {
    return std::any_of(names.begin(), names.end(),
                       [&](const char* name) { return std::string_view(node.name()) == name; });
  };
  const pugi::xml_node root = xml.root();
  if (matches(root)) return root;
  std::string found = root.name();
  if (found == "OpenSimDocument") {
    for (const pugi::xml_node child : root.children()) {
      if (matches(child)) return child;
    }
    found += fmt::format(" with <{}>", root.first_child().name());
  }
  xml.fail(root, {fmt::format("holds no {}", *names.begin()),
                  fmt::format("an OpenSimDocument with <{}>", fmt::join(names, "> or <")), found,
                  "Name the setup file of this tool."});
}

SetupFields::SetupFields(const XmlFile& xml, std::vector<pugi::xml_node> nodes, SetupLines& lines)
    : xml_(xml), nodes_(std::move(nodes)), lines_(lines) {}

pugi::xml_node SetupFields::find(const char* name) {
  for (const pugi::xml_node node : nodes_) {
    if (const pugi::xml_node child = node.child(name)) {
      lines_[name] = xml_.location(child).line;
      return child;
    }
  }
  return {};
}

std::string SetupFields::text(const char* name) {
  std::string result = xml_.text(find(name));
  return text::equals_ignoring_case(result, "Unassigned") ? "" : result;
}

fs::path SetupFields::file(const char* name) { return resolve_setup_path(text(name), xml_.path()); }

std::optional<double> SetupFields::number(const char* name) {
  if (text(name).empty()) return std::nullopt;
  const pugi::xml_node node = find(name);
  const std::optional<double> value = xml_.number(node.parent(), name);
  if (value && std::isnan(*value)) {
    xml_.fail(node, {fmt::format("<{}> is NaN", name), "a number", "", "Correct the value."});
  }
  return value;
}

std::vector<std::string> SetupFields::words(const char* name) {
  if (text(name).empty()) return {};
  return xml_.words(find(name).parent(), name);
}

std::pair<std::optional<double>, std::optional<double>> SetupFields::time_range(const char* name) {
  if (text(name).empty()) return {};
  const pugi::xml_node node = find(name);
  const std::vector<double> values = xml_.numbers(node);
  if (values.size() != 2 || std::isnan(values[0]) || std::isnan(values[1])) {
    xml_.fail(node, {fmt::format("<{}> is no range", name), "two times in seconds", xml_.text(node),
                     "Give the first and the last time."});
  }
  std::optional<double> from, to;
  if (std::isfinite(values[0])) from = values[0];
  if (std::isfinite(values[1])) to = values[1];
  if (from && to && *from > *to) {
    xml_.fail(node, {fmt::format("<{}> ends before it begins", name), "the earlier time first",
                     xml_.text(node), "Exchange the two times."});
  }
  return {from, to};
}

}  // namespace sinew
