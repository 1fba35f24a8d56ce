#include "data/xml_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <sstream>
#include <utility>

#include "data/input_file.h"

namespace sinew {
namespace {

// A detailed model is about 2 MiB; 256 MiB bounds memory and is larger than any model we know.
constexpr std::size_t kMaxXmlBytes = std::size_t{256} << 20;

// Elements of real models nest to about 15; deeper input would only exhaust the stack of readers
// that recurse.
constexpr int kMaxDepth = 200;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::vector<std::string_view> split_words(std::string_view text) {
  std::vector<std::string_view> words;
  std::size_t i = 0;
  while (i < text.size()) {
    while (i < text.size() && is_space(text[i])) ++i;
    const std::size_t begin = i;
    while (i < text.size() && !is_space(text[i])) ++i;
    if (i > begin) words.push_back(text.substr(begin, i - begin));
  }
  return words;
}

// Like std::from_chars, and `nan`, `inf`, `infinity` in any case and a leading plus.
bool parse_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) {
    // Too small to represent is zero; too large is no usable number.
    const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
    value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return tiny;
  }
  return error == std::errc() && end == word.data() + word.size();
}

int depth_of(pugi::xml_node root) {
  struct Walker : pugi::xml_tree_walker {
    int deepest = 0;
    bool for_each(pugi::xml_node&) override {
      deepest = std::max(deepest, depth());
      return deepest <= kMaxDepth;
    }
  } walker;
  root.traverse(walker);
  return walker.deepest;
}

}  // namespace

XmlFile::XmlFile(const std::filesystem::path& path, Keep keep)
    : path_(path.string()), content_(read_file(path, kMaxXmlBytes)) {
  parse(keep);
}

XmlFile::XmlFile(std::string name, std::string content, Keep keep)
    : path_(std::move(name)), content_(std::move(content)) {
  parse(keep);
}

std::string XmlFile::to_string() const {
  std::ostringstream out;
  // The parser drops the line ends between the document's own nodes, and only these.
  for (const pugi::xml_node node : document_.children()) {
    node.print(out, "", pugi::format_raw, pugi::encoding_utf8);
    out << '\n';
  }
  return out.str();
}

void XmlFile::parse(Keep keep) {
  line_starts_.push_back(0);
  for (std::size_t i = 0; i < content_.size(); ++i) {
    if (content_[i] == '\n') line_starts_.push_back(i + 1);
  }
  if (trimmed(content_).empty()) {
    throw InputError({path_}, {"is empty", "an XML document", "", "Was it written completely?"});
  }
  const unsigned flags = keep == Keep::kElements ? pugi::parse_default
                                                 : (pugi::parse_full | pugi::parse_ws_pcdata) &
                                                       ~static_cast<unsigned>(pugi::parse_eol);
  const pugi::xml_parse_result result =
      document_.load_buffer(content_.data(), content_.size(), flags, pugi::encoding_utf8);
  if (!result && !only_closing_tags_left(result)) {
    const auto offset = static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0));
    const auto line = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
    throw InputError({path_, static_cast<int>(line - line_starts_.begin())},
                     {fmt::format("is not well-formed XML ({})", result.description()), "", "",
                      "Is the file complete, and is it an XML file?"});
  }
  if (!root()) {
    throw InputError({path_},
                     {"has no XML element", "an OpenSimDocument", "", "Is it an XML file?"});
  }
  if (depth_of(root()) > kMaxDepth) {
    throw InputError({path_}, {"nests its elements too deeply",
                               fmt::format("at most {} levels", kMaxDepth), "", ""});
  }
}

// Some setups end in a closing tag too many; OpenSim reads them, and nothing is lost.
bool XmlFile::only_closing_tags_left(const pugi::xml_parse_result& result) const {
  if (result.status != pugi::status_end_element_mismatch || !root()) return false;
  const std::string_view content = content_;
  std::size_t at =
      content.rfind('<', static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)));
  const std::string root_end = std::string("</") + root().name() + ">";
  const std::size_t root_closed = content.find(root_end);
  if (at == content.npos || root_closed == content.npos || root_closed >= at) return false;
  while (at < content.size()) {
    if (is_space(content[at])) {
      ++at;
      continue;
    }
    if (content.substr(at, 2) != "</") return false;
    at = content.find('>', at);
    if (at == content.npos) return false;
    ++at;
  }
  return true;
}

SourceLocation XmlFile::location(pugi::xml_node node) const {
  const std::ptrdiff_t offset = node.offset_debug();
  if (offset < 0) return {path_, 0};
  const auto line =
      std::upper_bound(line_starts_.begin(), line_starts_.end(), static_cast<std::size_t>(offset));
  return {path_, static_cast<int>(line - line_starts_.begin())};
}

std::string XmlFile::text(pugi::xml_node node) const {
  // Text may be split by comments, so all of the element's own pieces are joined.
  std::string joined;
  for (const pugi::xml_node piece : node.children()) {
    if (piece.type() == pugi::node_pcdata || piece.type() == pugi::node_cdata) {
      joined += piece.value();
      joined += ' ';
    }
  }
  return std::string(trimmed(joined));
}

std::string XmlFile::text(pugi::xml_node parent, const char* name) const {
  return text(parent.child(name));
}

std::vector<double> XmlFile::numbers(pugi::xml_node node) const {
  const std::string content = text(node);
  std::vector<double> values;
  for (const std::string_view word : split_words(content)) {
    double value = 0.0;
    if (!parse_number(word, value)) {
      fail(node, {fmt::format("<{}> holds a word that is no number", node.name()),
                  "numbers separated by spaces", std::string(word), "Correct the value."});
    }
    values.push_back(value);
  }
  return values;
}

std::optional<Eigen::Vector3d> XmlFile::vector3(pugi::xml_node parent, const char* name) const {
  const pugi::xml_node node = parent.child(name);
  if (!node) return std::nullopt;
  const std::vector<double> values = numbers(node);
  if (values.empty()) return std::nullopt;
  if (values.size() != 3) {
    fail(node, {fmt::format("<{}> has the wrong number of values", name), "3",
                std::to_string(values.size()), "Give x, y and z."});
  }
  return Eigen::Vector3d(values[0], values[1], values[2]);
}

std::optional<double> XmlFile::number(pugi::xml_node parent, const char* name) const {
  const pugi::xml_node node = parent.child(name);
  if (!node) return std::nullopt;
  const std::vector<double> values = numbers(node);
  if (values.empty()) return std::nullopt;
  if (values.size() != 1) {
    fail(node, {fmt::format("<{}> has the wrong number of values", name), "1",
                std::to_string(values.size()), "Give one number."});
  }
  return values[0];
}

std::optional<bool> XmlFile::boolean(pugi::xml_node parent, const char* name) const {
  const pugi::xml_node node = parent.child(name);
  const std::string word = lower(text(node));
  if (word.empty()) return std::nullopt;
  if (word == "true" || word == "1") return true;
  if (word == "false" || word == "0") return false;
  fail(node, {fmt::format("<{}> is neither true nor false", name), "true or false", word,
              "Correct the value."});
}

std::vector<std::string> XmlFile::words(pugi::xml_node parent, const char* name) const {
  const std::string content = text(parent, name);
  std::vector<std::string> result;
  for (const std::string_view word : split_words(content)) result.emplace_back(word);
  return result;
}

void XmlFile::fail(pugi::xml_node node, InputError::Parts parts) const {
  throw InputError(location(node), std::move(parts));
}

}  // namespace sinew
