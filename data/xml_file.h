#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "data/input_error.h"

namespace sinew {

/// A parsed XML file that knows on which line each element stands, and reads typed values with
/// errors that name element, line and remedy. Stray non-UTF-8 bytes and names such as
/// `HuntCrossleyForce::ContactParameters` are accepted as OpenSim accepts them.
class XmlFile {
 public:
  enum class Keep {
    kElements,    // what readers need
    kEverything,  // comments, white space and line endings too, so that to_string() gives them back
  };

  /// Throws InputError if the file is missing, empty, over 256 MiB, or not XML.
  explicit XmlFile(const std::filesystem::path& path, Keep keep = Keep::kElements);
  /// Parses `content` as if it had been read from `name`.
  XmlFile(std::string name, std::string content, Keep keep = Keep::kElements);

  pugi::xml_node root() const { return document_.document_element(); }
  /// The document with all changes made through its nodes. Of Keep::kEverything what was not
  /// changed stays as it was read, but for the spelling of entities and of empty elements.
  std::string to_string() const;
  const std::string& path() const { return path_; }
  SourceLocation location(pugi::xml_node node) const;

  /// Text of the element, or of its child `name`, with surrounding white space removed; empty
  /// where the child is missing.
  std::string text(pugi::xml_node node) const;
  std::string text(pugi::xml_node parent, const char* name) const;

  /// Numbers separated by white space. `nan`, `inf`, `infinity` are read in any case.
  /// Throws InputError naming the element if a word is no number.
  std::vector<double> numbers(pugi::xml_node node) const;
  /// Exactly three numbers, or nothing if the child is missing or empty.
  std::optional<Eigen::Vector3d> vector3(pugi::xml_node parent, const char* name) const;
  /// One number; nothing if the child is missing or empty. Throws if it is not exactly one.
  std::optional<double> number(pugi::xml_node parent, const char* name) const;
  /// `true`, `false`, 1 or 0 in any case; nothing if missing or empty.
  std::optional<bool> boolean(pugi::xml_node parent, const char* name) const;
  /// Words separated by white space; empty where the child is missing.
  std::vector<std::string> words(pugi::xml_node parent, const char* name) const;

  [[noreturn]] void fail(pugi::xml_node node, InputError::Parts parts) const;

 private:
  void parse(Keep keep);
  bool only_closing_tags_left(const pugi::xml_parse_result& result) const;

  std::string path_;
  std::string content_;
  std::vector<std::size_t> line_starts_;  // offset of each line's first byte
  pugi::xml_document document_;
};

}  // namespace sinew
