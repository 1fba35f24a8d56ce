#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/tool_setup.h"
#include "data/xml_file.h"

namespace sinew {

/// The element that `names` call a tool: the document's root, or the first of the root's children
/// where the root is an OpenSimDocument. Throws InputError naming the wrong root.
pugi::xml_node find_tool(const XmlFile& xml, std::initializer_list<const char*> names);

/// Reads the fields that OpenSim's tools share and notes on which line each stands.
class SetupFields {
 public:
  /// The fields are children of one of `nodes`; the first that has a field gives it.
  SetupFields(const XmlFile& xml, std::vector<pugi::xml_node> nodes, SetupLines& lines);

  /// The child, or an empty node; and notes its line.
  pugi::xml_node find(const char* name);
  /// Text of the field; empty if missing or `Unassigned`.
  std::string text(const char* name);
  /// The field as a path; empty if missing or `Unassigned`. See IkSetup for how it is resolved.
  std::filesystem::path file(const char* name);
  /// One number that is not NaN; nothing if missing, empty or `Unassigned`.
  std::optional<double> number(const char* name);
  std::vector<std::string> words(const char* name);
  /// Two numbers in order; an infinite one is nothing, as both are if the field is missing.
  std::pair<std::optional<double>, std::optional<double>> time_range(const char* name);

 private:
  const XmlFile& xml_;
  std::vector<pugi::xml_node> nodes_;
  SetupLines& lines_;
};

/// The <IKTaskSet> of a tool, which may stand in a file of its own. Throws InputError if the tool
/// has none or the file does not exist.
IkTaskSet read_tasks_of(const XmlFile& xml, SetupFields& fields, pugi::xml_node tool);

/// A path as a setup file has it, made absolute against the folder of `setup_path`.
std::filesystem::path resolve_setup_path(const std::string& text,
                                         const std::filesystem::path& setup_path);

}  // namespace sinew
