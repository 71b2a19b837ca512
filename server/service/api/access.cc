#include "server/service/api/access.h"

#include <map>
#include <set>
#include <string>
#include <string_view>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "kerf/v1/access_service.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/stream.pb.h"

namespace kerf::api {
namespace {

using auth::Scope;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// The subject of a request, beside its scope.
enum class Subject {
  kNamedSheet,   // the sheet in its name or parent, or the sheets in its names
  kStartsSheet,  // the sheet in the name of its start, if it has one
  kNewSheet,     // a sheet that it makes
  kServer,       // the server as a whole, where the caller's sheets do not matter
  kAllSheets,    // everything: only those who reach all sheets
};

// Marks a call that changes something, or gives rights to others. DragPoint is not: a hand sends many a second.
constexpr bool kRecorded = true;

struct Rule {
  Scope scope;
  Subject subject;
  bool is_recorded = false;
};

const std::map<std::string_view, Rule>& rules() {
  static const std::map<std::string_view, Rule> table = {
      {"AnalyzeSheetRequest", {Scope::kCut, Subject::kNamedSheet}},  // It takes a processor for minutes.
      {"BackupStoreRequest", {Scope::kAdmin, Subject::kAllSheets, kRecorded}},
      {"CancelScheduledCutsRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"CreateCutRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"CreateCutsRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"CreateLinkRequest", {Scope::kView, Subject::kServer, kRecorded}},  // It gives no more than the caller has.
      {"CreateSheetRequest", {Scope::kAdmin, Subject::kNewSheet, kRecorded}},
      {"DeleteSetAsideSheetRequest", {Scope::kAdmin, Subject::kAllSheets, kRecorded}},
      {"DeleteSheetRequest", {Scope::kAdmin, Subject::kNamedSheet, kRecorded}},
      {"DeleteStateRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"DragPointRequest", {Scope::kCut, Subject::kNamedSheet}},
      {"ExportSheetRequest", {Scope::kView, Subject::kNamedSheet}},
      {"GetAccessRequest", {Scope::kView, Subject::kServer}},
      {"GetServerInfoRequest", {Scope::kView, Subject::kServer}},
      {"GetSheetRecordingRequest", {Scope::kView, Subject::kNamedSheet}},
      {"GetSheetRequest", {Scope::kView, Subject::kNamedSheet}},
      {"GetSheetStateRequest", {Scope::kView, Subject::kNamedSheet}},
      {"GetStoreInfoRequest", {Scope::kAdmin, Subject::kAllSheets}},
      {"GrabPointRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"InspectDrawingRequest", {Scope::kCut, Subject::kServer}},  // They take a processor, and read no sheet.
      {"InspectMeshRequest", {Scope::kCut, Subject::kServer}},
      {"ListCutsRequest", {Scope::kView, Subject::kNamedSheet}},
      {"ListPiecesRequest", {Scope::kView, Subject::kNamedSheet}},
      {"ListSheetsRequest", {Scope::kView, Subject::kServer}},  // The list has those that the caller reaches.
      {"ListStatesRequest", {Scope::kView, Subject::kNamedSheet}},
      {"PauseSheetRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"PruneStoreRequest", {Scope::kAdmin, Subject::kAllSheets, kRecorded}},
      {"RecordingUpload", {Scope::kAdmin, Subject::kNewSheet, kRecorded}},
      {"RedoCutRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"ReleasePointRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"RenderImageRequest", {Scope::kView, Subject::kNamedSheet}},
      {"ResetSheetRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"RestoreStateRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"ResumeSheetRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SaveStateRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SetSheetGravityRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SetSheetMaterialRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SetSheetPinsRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SetSheetSelfContactRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SetSheetSpeedRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SetSheetWindRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SheetUpload", {Scope::kAdmin, Subject::kNewSheet, kRecorded}},
      {"StepSheetRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"StepSheetsRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"SubscribeRequest", {Scope::kView, Subject::kNamedSheet}},
      {"UndoCutRequest", {Scope::kCut, Subject::kNamedSheet, kRecorded}},
      {"WatchImagesRequest", {Scope::kView, Subject::kStartsSheet}},
      {"WatchImagesStart", {Scope::kView, Subject::kNamedSheet}},
      {"WatchRequest", {Scope::kView, Subject::kStartsSheet}},  // See needed_scope().
  };
  return table;
}

// Hands in a stream change the sheet; its other requests only watch.
Scope needed_scope(const Message& request, const Rule& rule) {
  const auto* const watch = dynamic_cast<const v1::WatchRequest*>(&request);
  if (watch == nullptr) return rule.scope;
  return watch->has_grab() || watch->has_drag() || watch->has_release() ? Scope::kCut : Scope::kView;
}

// Returns the sheet's id in `sheets/{sheet}` or `sheets/{sheet}/...`, well-formed or not.
std::string_view sheet_in(std::string_view name) {
  constexpr std::string_view kSheets = "sheets/";
  if (!name.starts_with(kSheets)) return {};
  name.remove_prefix(kSheets.size());
  return name.substr(0, name.find('/'));
}

// Checks a name of a sheet. A name that is malformed names no sheet, and the method says so.
Status check_name(const auth::Rights& rights, const std::string& name, const std::string& field) {
  const std::string id(sheet_in(name));
  if (id.empty() || rights.reaches(id)) return Nothing{};
  return not_found("SHEET_NOT_FOUND", "there is no sheet \"" + id + "\"", field);
}

Status check_named(const auth::Rights& rights, const Message& request, const std::string& prefix) {
  if (const auto* const steps = dynamic_cast<const v1::StepSheetsRequest*>(&request)) {
    for (int i = 0; i < steps->names_size(); ++i) {
      KERF_TRY(check_name(rights, steps->names(i), "names[" + std::to_string(i) + "]"));
    }
    return Nothing{};
  }
  for (const char* const field : {"name", "parent"}) {
    const FieldDescriptor* const descriptor = request.GetDescriptor()->FindFieldByName(field);
    if (descriptor == nullptr) continue;
    KERF_TRY(check_name(rights, request.GetReflection()->GetString(request, descriptor), prefix + field));
  }
  return Nothing{};
}

Status check_start(const auth::Rights& rights, const Message& request) {
  const FieldDescriptor* const start = request.GetDescriptor()->FindFieldByName("start");
  if (!request.GetReflection()->HasField(request, start)) return Nothing{};
  return check_named(rights, request.GetReflection()->GetMessage(request, start), "start.");
}

std::string id_of(const v1::CreateSheetRequest& request) {
  return request.sheet_id().empty() ? request.scene().sheet_id() : request.sheet_id();
}

std::string new_sheet_in(const Message& request) {
  if (const auto* const create = dynamic_cast<const v1::CreateSheetRequest*>(&request)) return id_of(*create);
  if (const auto* const upload = dynamic_cast<const v1::SheetUpload*>(&request)) return id_of(upload->sheet());
  const auto* const recording = dynamic_cast<const v1::RecordingUpload*>(&request);
  return recording == nullptr ? std::string() : recording->sheet_id();
}

Status check_new(const auth::Rights& rights, const Message& request) {
  const std::string id = new_sheet_in(request);
  if (!id.empty() && rights.reaches(id)) return Nothing{};
  return permission_denied("SHEET_NOT_ALLOWED",
                           "this token makes sheets whose ids fit \"" + rights.sheets + "\"; give such a sheet_id",
                           "sheet_id");
}

Status check_subject(const auth::Rights& rights, Subject subject, const Message& request) {
  if (rights.reaches_all()) return Nothing{};
  switch (subject) {
    case Subject::kNamedSheet:
      return check_named(rights, request, "");
    case Subject::kStartsSheet:
      return check_start(rights, request);
    case Subject::kNewSheet:
      return check_new(rights, request);
    case Subject::kServer:
      return Nothing{};
    case Subject::kAllSheets:
      break;
  }
  return permission_denied("SHEET_NOT_ALLOWED",
                           "this concerns all sheets, and the token reaches \"" + rights.sheets + "\" alone");
}

}  // namespace

Status check_access(const auth::Caller& caller, const Message& request) {
  KERF_TRY(caller->check());
  const auto rule = rules().find(request.GetDescriptor()->name());
  if (rule == rules().end()) {
    return permission_denied("SCOPE_TOO_LOW", "no token allows " + request.GetDescriptor()->full_name());
  }
  const Scope needed = needed_scope(request, rule->second);
  if (caller->rights().scope < needed) {
    return permission_denied("SCOPE_TOO_LOW",
                             "this needs a token with scope " + std::string(auth::name_of(needed)) + "; yours has " +
                                 std::string(auth::name_of(caller->rights().scope)),
                             "authorization");
  }
  return check_subject(caller->rights(), rule->second.subject, request);
}

bool is_recorded(const Message& request) {
  const FieldDescriptor* const dry = request.GetDescriptor()->FindFieldByName("validate_only");
  if (dry != nullptr && request.GetReflection()->GetBool(request, dry)) return false;
  const auto rule = rules().find(request.GetDescriptor()->name());
  return rule != rules().end() && rule->second.is_recorded;
}

std::string call_of(const Message& request) {
  std::string name = request.GetDescriptor()->name();
  if (name == "SheetUpload") return "UploadSheet";
  if (name == "RecordingUpload") return "ReplayRecording";
  constexpr std::string_view kRequest = "Request";
  if (name.ends_with(kRequest)) name.erase(name.size() - kRequest.size());
  return name;
}

std::set<std::string> sheets_of(const Message& request) {
  const auto* const steps = dynamic_cast<const v1::StepSheetsRequest*>(&request);
  if (steps == nullptr) return {sheet_of(request)};
  std::set<std::string> ids;
  for (const std::string& name : steps->names()) ids.emplace(sheet_in(name));
  return ids;
}

std::string sheet_of(const Message& request) {
  if (const auto* const link = dynamic_cast<const v1::CreateLinkRequest*>(&request)) return link->sheet_id();
  for (const char* const field : {"name", "parent"}) {
    const FieldDescriptor* const descriptor = request.GetDescriptor()->FindFieldByName(field);
    if (descriptor == nullptr) continue;
    std::string id(sheet_in(request.GetReflection()->GetString(request, descriptor)));
    if (!id.empty()) return id;
  }
  return new_sheet_in(request);
}

std::vector<std::string> messages_with_rules() {
  std::vector<std::string> names;
  for (const auto& [name, rule] : rules()) names.push_back("kerf.v1." + std::string(name));
  return names;
}

}  // namespace kerf::api
