#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/api/fixture.h"

namespace kerf::api {

// Calls of the service of cuts on the sheet "a".
class ApiCutsTest : public ApiTest {
 protected:
  static v1::CreateCutsRequest batch_request(const std::string& parent, const std::vector<double>& heights) {
    v1::CreateCutsRequest request;
    request.set_parent(parent);
    for (const double y : heights) *request.add_cuts() = cut_request(parent, y).cut();
    return request;
  }
  Result<v1::UndoResult> undo(const std::string& request_id = {}) {
    v1::UndoCutRequest request;
    request.set_parent("sheets/a");
    request.set_request_id(request_id);
    return call(&Api::undo_cut, request);
  }
  Result<v1::UndoResult> redo() {
    v1::RedoCutRequest request;
    request.set_parent("sheets/a");
    return call(&Api::redo_cut, request);
  }
  v1::ListCutsResponse list(const std::string& parent = "sheets/a") {
    v1::ListCutsRequest request;
    request.set_parent(parent);
    return call(&Api::list_cuts, request).value();
  }
  std::vector<std::string> names() {
    std::vector<std::string> found;
    const v1::ListCutsResponse all = list();
    for (const auto& entry : all.cuts()) found.push_back(entry.result().name());
    return found;
  }
  Result<v1::Sheet> step(std::int32_t ticks) {
    v1::StepSheetRequest request;
    request.set_name("sheets/a");
    request.set_ticks(ticks);
    return call(&Api::step_sheet, request);
  }
};

}  // namespace kerf::api
