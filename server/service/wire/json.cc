#include "server/service/wire/json.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include "server/base/check.h"
#include "server/base/text_encoding.h"
#include "server/service/wire/json_check.h"

namespace kerf::wire {

std::string to_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(message, &json, options);
  KERF_CHECK(status.ok(), "a message that has no JSON form");
  return json;
}

Status from_json(std::string_view json, google::protobuf::Message& message) {
  json = without_byte_order_mark(json);
  KERF_TRY(check_json(json, *message.GetDescriptor()));
  message.Clear();
  const auto status =
      google::protobuf::util::JsonStringToMessage(google::protobuf::StringPiece(json.data(), json.size()), &message);
  // Reports the faults left after the check: bad escapes, base64, UTF-8.
  if (!status.ok()) return invalid_argument("JSON_SYNTAX", std::string(status.message()));
  return Nothing{};
}

}  // namespace kerf::wire
