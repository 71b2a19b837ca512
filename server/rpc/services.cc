#include "server/rpc/services.h"

#include <grpcpp/support/server_callback.h>

#include <utility>

#include "kerf/v1/cuts.grpc.pb.h"
#include "kerf/v1/interaction.grpc.pb.h"
#include "kerf/v1/render.grpc.pb.h"
#include "kerf/v1/server.grpc.pb.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "kerf/v1/stream.grpc.pb.h"
#include "server/api/api.h"
#include "server/rpc/grpc_status.h"

namespace kerf::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

// Hands the request to the Api's method of the same name. gRPC keeps request and response until the reactor finishes.
template <typename Request, typename Response>
Reactor* answer(api::Api& api, void (api::Api::*method)(const Request&, api::Reply<Response>), Context* context,
                const Request* request, Response* response) {
  Reactor* reactor = context->DefaultReactor();
  (api.*method)(*request, [reactor, response](Result<Response> reply) {
    if (!reply) {
      reactor->Finish(to_status(reply.error()));
      return;
    }
    *response = std::move(*reply);
    reactor->Finish(grpc::Status::OK);
  });
  return reactor;
}

// One override of a generated callback service: it does nothing but name the Api's method.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define KERF_UNARY(Rpc, method, Request, Response)                                                       \
  grpc::ServerUnaryReactor* Rpc(Context* context, const Request* request, Response* response) override { \
    return answer(api_, &api::Api::method, context, request, response);                                  \
  }
// NOLINTEND(bugprone-macro-parentheses)

class Sheets final : public v1::SheetService::CallbackService {
 public:
  explicit Sheets(api::Api& api) : api_(api) {}
  KERF_UNARY(CreateSheet, create_sheet, v1::CreateSheetRequest, v1::Sheet)
  KERF_UNARY(GetSheet, get_sheet, v1::GetSheetRequest, v1::Sheet)
  KERF_UNARY(ListSheets, list_sheets, v1::ListSheetsRequest, v1::ListSheetsResponse)
  KERF_UNARY(DeleteSheet, delete_sheet, v1::DeleteSheetRequest, google::protobuf::Empty)
  KERF_UNARY(PauseSheet, pause_sheet, v1::PauseSheetRequest, v1::Sheet)
  KERF_UNARY(ResumeSheet, resume_sheet, v1::ResumeSheetRequest, v1::Sheet)
  KERF_UNARY(StepSheet, step_sheet, v1::StepSheetRequest, v1::Sheet)
  KERF_UNARY(ResetSheet, reset_sheet, v1::ResetSheetRequest, v1::Sheet)
  KERF_UNARY(ExportSheet, export_sheet, v1::ExportSheetRequest, v1::ExportSheetResponse)
  KERF_UNARY(GetSheetState, get_sheet_state, v1::GetSheetStateRequest, v1::SheetState)

 private:
  api::Api& api_;
};

class Cuts final : public v1::CutService::CallbackService {
 public:
  explicit Cuts(api::Api& api) : api_(api) {}
  KERF_UNARY(CreateCut, create_cut, v1::CreateCutRequest, v1::CutResult)
  KERF_UNARY(ListCuts, list_cuts, v1::ListCutsRequest, v1::ListCutsResponse)

 private:
  api::Api& api_;
};

class Interaction final : public v1::InteractionService::CallbackService {
 public:
  explicit Interaction(api::Api& api) : api_(api) {}
  KERF_UNARY(GrabPoint, grab_point, v1::GrabPointRequest, v1::InteractionResponse)
  KERF_UNARY(DragPoint, drag_point, v1::DragPointRequest, v1::InteractionResponse)
  KERF_UNARY(ReleasePoint, release_point, v1::ReleasePointRequest, v1::InteractionResponse)
  KERF_UNARY(SetSheetPins, set_sheet_pins, v1::SetSheetPinsRequest, v1::InteractionResponse)
  KERF_UNARY(SetSheetGravity, set_sheet_gravity, v1::SetSheetGravityRequest, v1::InteractionResponse)
  KERF_UNARY(SetSheetWind, set_sheet_wind, v1::SetSheetWindRequest, v1::InteractionResponse)

 private:
  api::Api& api_;
};

class Render final : public v1::RenderService::CallbackService {
 public:
  explicit Render(api::Api& api) : api_(api) {}
  KERF_UNARY(RenderImage, render_image, v1::RenderImageRequest, v1::RenderImageResponse)

 private:
  api::Api& api_;
};

class ServerInformation final : public v1::ServerService::CallbackService {
 public:
  explicit ServerInformation(api::Api& api) : api_(api) {}
  KERF_UNARY(GetServerInfo, get_server_info, v1::GetServerInfoRequest, v1::ServerInfo)

 private:
  api::Api& api_;
};

#undef KERF_UNARY

}  // namespace

std::vector<NamedService> make_services(api::Api& api) {
  std::vector<NamedService> services;
  services.push_back({v1::SheetService::service_full_name(), std::make_unique<Sheets>(api)});
  services.push_back({v1::CutService::service_full_name(), std::make_unique<Cuts>(api)});
  services.push_back({v1::InteractionService::service_full_name(), std::make_unique<Interaction>(api)});
  services.push_back({v1::StreamService::service_full_name(), make_stream_service(api)});
  services.push_back({v1::RenderService::service_full_name(), std::make_unique<Render>(api)});
  services.push_back({v1::ServerService::service_full_name(), std::make_unique<ServerInformation>(api)});
  return services;
}

}  // namespace kerf::rpc
