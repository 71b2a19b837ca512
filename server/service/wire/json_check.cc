#include "server/service/wire/json_check.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include <google/protobuf/descriptor.h>

#include "server/base/text_encoding.h"

namespace kerf::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

constexpr std::size_t kMaxShown = 80;  // Bytes of a value in a message.

class Checker {
 public:
  explicit Checker(std::string_view text) : text_(text) {}

  Status run(const Descriptor& type) {
    if (text_.starts_with("\x1f\x8b")) {
      fail("JSON_SYNTAX", "the text is compressed by gzip; send it as it is", "");
    } else if (check_encoding()) {
      object(type, "");
    }
    if (!error_) {
      skip_blanks();
      if (at_ < text_.size()) fail("JSON_SYNTAX", "there is text after the end of the document", "");
    }
    return error_ ? Status(*error_) : Status(Nothing{});
  }

 private:
  // Names the first byte that is no part of a character.
  bool check_encoding() {
    if (is_utf8(text_)) return true;
    for (token_ = 0; token_ < text_.size();) {
      std::size_t length = 1;
      while (length <= 4 && !is_utf8(text_.substr(token_, length))) ++length;
      if (length > 4) break;
      token_ += length;
    }
    return fail("JSON_SYNTAX", "a byte that is not UTF-8; save the text in that encoding", "");
  }

  // Records the first fault only; all callers return soon after.
  bool fail(std::string reason, const std::string& what, const std::string& path) {
    if (error_) return false;
    std::size_t line = 1;
    std::size_t column = 1;
    for (std::size_t i = 0; i < std::min(token_, text_.size()); ++i) {
      column = text_[i] == '\n' ? 1 : column + 1;
      if (text_[i] == '\n') ++line;
    }
    std::string message = "line " + std::to_string(line) + ", column " + std::to_string(column) + ": ";
    if (!path.empty()) message += path + ": ";
    error_ = invalid_argument(std::move(reason), message + what, path);
    return false;
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
    token_ = at_;
  }
  char peek() {
    skip_blanks();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool expect(char wanted, const std::string& path) {
    if (peek() != wanted) return fail("JSON_SYNTAX", "expected " + std::string(1, wanted) + found(), path);
    ++at_;
    return true;
  }
  [[nodiscard]] std::string found() const {
    if (at_ >= text_.size()) return ", found the end of the text";
    const char c = text_[at_];
    return std::isprint(static_cast<unsigned char>(c)) != 0 ? std::string(", found ") + c
                                                            : ", found an unexpected byte";
  }

  // Reads a string in double quotes. Escapes stay as they are, which is enough to compare names.
  bool quoted(std::string& content, const std::string& path) {
    if (!expect('"', path)) return false;
    content.clear();
    while (at_ < text_.size() && text_[at_] != '"') {
      const char c = text_[at_];
      if (static_cast<unsigned char>(c) < 0x20) return fail("JSON_SYNTAX", "a control character in a string", path);
      if (c == '\\' && at_ + 1 < text_.size()) content.push_back(text_[at_++]);
      content.push_back(text_[at_++]);
    }
    if (at_ >= text_.size()) return fail("JSON_SYNTAX", "a string that does not end", path);
    ++at_;
    return true;
  }

  // Reads a number, or one of the words true, false, null, as text.
  bool bare(std::string& content, const std::string& path) {
    skip_blanks();
    content.clear();
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 ||
                                  std::string_view("+-._").find(text_[at_]) != std::string_view::npos)) {
      content.push_back(text_[at_++]);
    }
    return !content.empty() || fail("JSON_SYNTAX", "expected a value" + found(), path);
  }

  // Calls `element(name of this member)`, or `element("")` in an array, with the reader at its value.
  template <typename Element>
  bool list(char open, char close, const std::string& path, Element element) {
    if (!expect(open, path)) return false;
    if (peek() == close) {
      ++at_;
      return true;
    }
    while (true) {
      if (!element()) return false;
      const char next = peek();
      if (next != ',' && next != close) {
        return fail("JSON_SYNTAX", std::string("expected , or ") + close + found(), path);
      }
      ++at_;
      if (next == close) return true;
      if (peek() == close) return fail("JSON_SYNTAX", std::string("a comma before ") + close, path);
    }
  }

  bool object(const Descriptor& type, const std::string& path) {
    if (peek() != '{') return fail("JSON_TYPE", "expected an object" + found(), path);
    std::set<std::string> seen;
    return list('{', '}', path, [&] {
      std::string name;
      skip_blanks();
      const std::size_t name_at = at_;
      if (peek() != '"') return fail("JSON_SYNTAX", "expected a name in double quotes" + found(), path);
      if (!quoted(name, path)) return false;
      const FieldDescriptor* field = type.FindFieldByName(name);
      if (field == nullptr) field = type.FindFieldByCamelcaseName(name);
      const std::string member = path.empty() ? name : path + "." + name;
      token_ = name_at;
      if (field == nullptr) return fail("JSON_UNKNOWN_FIELD", unknown(type), member);
      const std::string full = path.empty() ? field->name() : path + "." + field->name();
      if (!seen.insert(field->name()).second) return fail("JSON_DUPLICATE_FIELD", "given twice", full);
      if (!expect(':', full)) return false;
      const bool is_null = peek() == 'n';
      if (const auto* choice = field->real_containing_oneof(); choice != nullptr && !is_null) {
        if (!seen.insert("oneof " + choice->name()).second) {
          token_ = name_at;
          return fail("JSON_DUPLICATE_FIELD", "another choice of " + choice->name() + " is already given", full);
        }
      }
      return is_null ? null(full) : value(*field, full);
    });
  }

  static std::string unknown(const Descriptor& type) {
    std::string names;
    for (int i = 0; i < type.field_count(); ++i) names += (i == 0 ? "" : ", ") + type.field(i)->name();
    return "there is no such field; " + type.name() + " has: " + names;
  }

  bool null(const std::string& path) {
    std::string word;
    return bare(word, path) && (word == "null" || fail("JSON_SYNTAX", "expected null, found " + word, path));
  }

  bool value(const FieldDescriptor& field, const std::string& path) {
    if (!field.is_repeated()) return single(field, path);
    if (field.is_map()) return map(*field.message_type()->FindFieldByName("value"), path);
    if (peek() != '[') return fail("JSON_TYPE", "expected an array" + found(), path);
    std::size_t index = 0;
    return list('[', ']', path, [&] { return single(field, path + "[" + std::to_string(index++) + "]"); });
  }

  // Reads a map, whose keys are strings as in all maps of the protocol.
  bool map(const FieldDescriptor& element, const std::string& path) {
    if (peek() != '{') return fail("JSON_TYPE", "expected an object" + found(), path);
    std::set<std::string> seen;
    return list('{', '}', path, [&] {
      std::string key;
      skip_blanks();
      token_ = at_;
      if (!quoted(key, path)) return false;
      const std::string member = path + "." + key;
      if (!seen.insert(key).second) return fail("JSON_DUPLICATE_FIELD", "given twice", member);
      return expect(':', member) && single(element, member);
    });
  }

  bool single(const FieldDescriptor& field, const std::string& path) {
    if (field.message_type() != nullptr) return object(*field.message_type(), path);
    const char first = peek();
    if (first == '{' || first == '[') return fail("JSON_TYPE", "expected " + kind_of(field) + found(), path);
    std::string token;
    const bool is_string = first == '"';
    if (!(is_string ? quoted(token, path) : bare(token, path))) return false;
    if (fits(field, token, is_string)) return true;
    const std::string quote = is_string ? "\"" : "";
    return fail("JSON_TYPE", "expected " + kind_of(field) + ", found " + quote + shortened(token, kMaxShown) + quote,
                path);
  }

  static std::string kind_of(const FieldDescriptor& field) {
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL:
        return "true or false";
      case FieldDescriptor::CPPTYPE_STRING:
        return field.type() == FieldDescriptor::TYPE_BYTES ? "a string in base64" : "a string";
      case FieldDescriptor::CPPTYPE_ENUM: {
        std::string names = "one of";
        for (int i = 1; i < field.enum_type()->value_count(); ++i) names += " " + field.enum_type()->value(i)->name();
        return names;
      }
      case FieldDescriptor::CPPTYPE_DOUBLE:
      case FieldDescriptor::CPPTYPE_FLOAT:
        return "a number";
      case FieldDescriptor::CPPTYPE_UINT32:
      case FieldDescriptor::CPPTYPE_UINT64:
        return "a whole number >= 0";
      default:
        return "a whole number";
    }
  }

  static bool fits(const FieldDescriptor& field, const std::string& token, bool is_string) {
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL:
        return !is_string && (token == "true" || token == "false");
      case FieldDescriptor::CPPTYPE_STRING:
        return is_string && (field.type() != FieldDescriptor::TYPE_BYTES || is_base64(token));
      case FieldDescriptor::CPPTYPE_ENUM:
        return is_string ? field.enum_type()->FindValueByName(token) != nullptr : is_whole(token, -0x1p31, 0x1p31);
      case FieldDescriptor::CPPTYPE_DOUBLE:
      case FieldDescriptor::CPPTYPE_FLOAT:
        return (is_string && (token == "NaN" || token == "Infinity" || token == "-Infinity")) ||
               number(token).has_value();
      case FieldDescriptor::CPPTYPE_INT32:
        return is_whole(token, -0x1p31, 0x1p31);
      case FieldDescriptor::CPPTYPE_INT64:
        return is_whole(token, -0x1p63, 0x1p63);
      case FieldDescriptor::CPPTYPE_UINT32:
        return is_whole(token, 0.0, 0x1p32);
      case FieldDescriptor::CPPTYPE_UINT64:
        return is_whole(token, 0.0, 0x1p64);
      default:
        return false;
    }
  }

  // True if a string with its escapes has only characters of base64.
  static bool is_base64(std::string_view token) {
    while (!token.empty() && token.back() == '=') token.remove_suffix(1);
    return std::all_of(token.begin(), token.end(), [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
             std::string_view("+/-_\\").find(c) != std::string_view::npos;
    });
  }

  static std::optional<double> number(const std::string& token) {
    double value = 0.0;
    const char* end = token.data() + token.size();
    const auto [stop, fault] = std::from_chars(token.data(), end, value);
    const bool starts_well = !token.empty() && (token[0] == '-' || std::isdigit(static_cast<unsigned char>(token[0])));
    if (!starts_well || stop != end || fault != std::errc() || !std::isfinite(value)) return std::nullopt;
    return value;
  }

  // True if the number lies in [low, high) and has no fraction.
  static bool is_whole(const std::string& token, double low, double high) {
    const auto value = number(token);
    return value && *value >= low && *value < high && std::floor(*value) == *value;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t token_ = 0;  // Start of the current token: the place that an error names.
  std::optional<Error> error_;
};

}  // namespace

Status check_json(std::string_view json, const Descriptor& type) {
  return Checker(json).run(type);
}

}  // namespace kerf::wire
