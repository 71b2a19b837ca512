#pragma once

#include <set>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/service/auth/grant.h"

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

namespace kerf::api {

// Decides whether a caller may send a request: a request of a unary method, one of a stream or its start, or the start
// of an upload. Errors: those of auth::Grant::check(); kPermissionDenied SCOPE_TOO_LOW or SHEET_NOT_ALLOWED; kNotFound
// SHEET_NOT_FOUND for a sheet that the caller does not reach.
Status check_access(const auth::Caller& caller, const google::protobuf::Message& request);

// Returns true if what becomes of a request is recorded, see Recorder: it changes something, or gives rights to others.
bool is_recorded(const google::protobuf::Message& request);
// Returns the name of the call that a request makes, such as "CreateCut".
std::string call_of(const google::protobuf::Message& request);
// Returns the id of the sheet that a request is about, well-formed or not; empty: none, or one without an id yet.
std::string sheet_of(const google::protobuf::Message& request);
// Returns the ids of all sheets that a request is about: more than one only if it has several names.
std::set<std::string> sheets_of(const google::protobuf::Message& request);

// Returns the full names of the messages for which there is a rule, in order. All others are refused.
std::vector<std::string> messages_with_rules();

}  // namespace kerf::api
