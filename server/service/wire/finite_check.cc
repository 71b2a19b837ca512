#include "server/service/wire/finite_check.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/reflection.h>

#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kerf::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

// Lists the fields of a type that hold floating-point numbers, or messages that do.
struct NumericFields {
  struct Nested {
    const FieldDescriptor* field;
    std::unique_ptr<const NumericFields> fields;
  };
  std::vector<const FieldDescriptor*> numbers;
  std::vector<Nested> messages;
};

NumericFields numeric_fields(const Descriptor& type) {
  NumericFields fields;
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    const FieldDescriptor::CppType kind = field->cpp_type();
    if (kind == FieldDescriptor::CPPTYPE_DOUBLE || kind == FieldDescriptor::CPPTYPE_FLOAT) {
      fields.numbers.push_back(field);
    } else if (kind == FieldDescriptor::CPPTYPE_MESSAGE) {
      NumericFields nested = numeric_fields(*field->message_type());
      if (nested.numbers.empty() && nested.messages.empty()) continue;
      fields.messages.push_back({field, std::make_unique<const NumericFields>(std::move(nested))});
    }
  }
  return fields;
}

// Returns the fields of a type of request; made once and kept.
const NumericFields& kept_fields(const Descriptor& type) {
  static std::mutex mutex;
  static std::map<const Descriptor*, NumericFields> kept;
  const std::lock_guard lock(mutex);
  const auto found = kept.find(&type);
  return found != kept.end() ? found->second : kept.emplace(&type, numeric_fields(type)).first->second;
}

std::string indexed(const FieldDescriptor& field, int index) {
  return field.name() + "[" + std::to_string(index) + "]";
}

template <typename Number>
std::optional<std::string> bad_one_of(const Message& message, const FieldDescriptor& field) {
  int index = 0;
  for (const Number number : message.GetReflection()->GetRepeatedFieldRef<Number>(message, &field)) {
    if (!std::isfinite(number)) return indexed(field, index);
    ++index;
  }
  return std::nullopt;
}

std::optional<std::string> bad_number(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  const bool is_double = field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (field.is_repeated()) return is_double ? bad_one_of<double>(message, field) : bad_one_of<float>(message, field);
  const bool is_finite = is_double ? std::isfinite(reflection.GetDouble(message, &field))
                                   : std::isfinite(reflection.GetFloat(message, &field));
  if (is_finite) return std::nullopt;
  return field.name();
}

struct BadNumber {
  std::string path;
  std::string reason;
};

// Returns the error reason for numbers in a message of this type; empty: that of the enclosing message.
std::string own_reason(const Descriptor& type) {
  if (type.name() == "Curve") return "CURVE_NOT_FINITE";
  if (type.name() == "InlineMesh") return "MESH_NOT_FINITE";
  return {};
}

// Returns `inner`, found in the message of `field`, as seen from the enclosing message: its path gets the prefix
// `name`. Its reason becomes own_reason() of that message's type, if there is one.
BadNumber bad_within(const FieldDescriptor& field, const std::string& name, BadNumber inner) {
  const std::string reason = own_reason(*field.message_type());
  return {name + "." + inner.path, reason.empty() ? std::move(inner.reason) : reason};
}

// Returns the first number that is not finite.
std::optional<BadNumber> first_bad(const Message& message, const NumericFields& fields) {
  for (const FieldDescriptor* field : fields.numbers) {
    if (std::optional<std::string> path = bad_number(message, *field)) return BadNumber{*path, "NOT_FINITE"};
  }
  const Reflection& reflection = *message.GetReflection();
  for (const NumericFields::Nested& nested : fields.messages) {
    if (!nested.field->is_repeated()) {
      if (!reflection.HasField(message, nested.field)) continue;
      const auto bad = first_bad(reflection.GetMessage(message, nested.field), *nested.fields);
      if (bad) return bad_within(*nested.field, nested.field->name(), *bad);
      continue;
    }
    const int count = reflection.FieldSize(message, nested.field);
    for (int i = 0; i < count; ++i) {
      const auto bad = first_bad(reflection.GetRepeatedMessage(message, nested.field, i), *nested.fields);
      if (bad) return bad_within(*nested.field, indexed(*nested.field, i), *bad);
    }
  }
  return std::nullopt;
}

}  // namespace

Status check_finite(const Message& request) {
  const std::optional<BadNumber> bad = first_bad(request, kept_fields(*request.GetDescriptor()));
  if (!bad) return Nothing{};
  return invalid_argument(bad->reason, bad->path + " must be a finite number", bad->path);
}

}  // namespace kerf::wire
