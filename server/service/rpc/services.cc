#include "server/service/rpc/services.h"

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "kerf/v1/access_service.grpc.pb.h"
#include "kerf/v1/cuts.grpc.pb.h"
#include "kerf/v1/files.grpc.pb.h"
#include "kerf/v1/interaction.grpc.pb.h"
#include "kerf/v1/render.grpc.pb.h"
#include "kerf/v1/server.grpc.pb.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "kerf/v1/store_service.grpc.pb.h"
#include "kerf/v1/stream.grpc.pb.h"
#include "server/service/api/access.h"
#include "server/service/api/api.h"
#include "server/service/api/image_session.h"
#include "server/service/rpc/grpc_caller.h"
#include "server/service/rpc/grpc_status.h"
#include "server/service/rpc/messages.h"
#include "server/service/rpc/session_reactor.h"

namespace kerf::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;
using grpc::ByteBuffer;

// Wraps a generated service so that its methods take and return bytes. Malformed messages are refused here, because
// gRPC would answer them with UNIMPLEMENTED.
template <typename Service, template <typename> class... WithRawMethod>
struct RawService {
  using type = Service;
};
template <typename Service, template <typename> class First, template <typename> class... Rest>
struct RawService<Service, First, Rest...> {
  using type = First<typename RawService<Service, Rest...>::type>;
};

// Returns a callback that finishes `reactor` with the reply.
template <typename Response>
api::Reply<Response> finisher(Reactor* reactor, ByteBuffer* response) {
  return [reactor, response](Result<Response> reply) {
    if (!reply.ok()) {
      reactor->Finish(to_status(reply.error()));
      return;
    }
    reactor->Finish(serialise(*reply, response));
  };
}

// Parses a Request; finishes the reactor and returns nothing if `bytes` are malformed.
template <typename Request>
std::optional<Request> parse(const ByteBuffer* bytes, Reactor* reactor) {
  Result<Request> request = parse_message<Request>(*bytes);
  if (request.ok()) return std::move(request).value();
  reactor->Finish(to_status(request.error()));
  return std::nullopt;
}

// Calls `call` with a request that its caller may send. gRPC keeps the response until the reactor finishes.
template <typename Request, typename Call>
void answer_allowed(api::Api& api, const Context& context, const ByteBuffer* bytes, Reactor* reactor,
                    const Call& call) {
  const Result<auth::Caller> caller = caller_of(api, context);
  if (!caller.ok()) return reactor->Finish(to_status(caller.error()));
  const std::optional<Request> request = parse<Request>(bytes, reactor);
  if (!request) return;
  if (const Status allowed = api.allow(*caller, *request); !allowed.ok()) {
    return reactor->Finish(to_status(allowed.error()));
  }
  call(*request, *caller);
}

// Passes the request to the Api's method of the same name.
template <typename Request, typename Response>
Reactor* answer(api::Api& api, void (api::Api::*method)(const Request&, api::Reply<Response>), Context* context,
                const ByteBuffer* bytes, ByteBuffer* response) {
  Reactor* reactor = context->DefaultReactor();
  answer_allowed<Request>(api, *context, bytes, reactor, [&](const Request& request, const auth::Caller& caller) {
    (api.*method)(request, api.recorded(caller, request, finisher<Response>(reactor, response)));
  });
  return reactor;
}

template <typename Request, typename Response>
Reactor* answer(api::Api& api, void (api::Api::*method)(const Request&, const auth::Caller&, api::Reply<Response>),
                Context* context, const ByteBuffer* bytes, ByteBuffer* response) {
  Reactor* reactor = context->DefaultReactor();
  answer_allowed<Request>(api, *context, bytes, reactor, [&](const Request& request, const auth::Caller& caller) {
    (api.*method)(request, caller, api.recorded(caller, request, finisher<Response>(reactor, response)));
  });
  return reactor;
}

// Holds a stop token that is triggered when the client or the deadline cancels the call.
class CancellableReactor final : public Reactor {
 public:
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  void OnCancel() override { source_.request_stop(); }
  void OnDone() override { delete this; }

 private:
  std::stop_source source_;
};

// Passes the request to a long method that can be stopped; otherwise as answer() above.
template <typename Request, typename Response>
Reactor* answer(api::Api& api, void (api::Api::*method)(const Request&, api::Reply<Response>, std::stop_token),
                Context* context, const ByteBuffer* bytes, ByteBuffer* response) {
  auto* reactor = new CancellableReactor;  // Deletes itself in OnDone.
  answer_allowed<Request>(api, *context, bytes, reactor, [&](const Request& request, const auth::Caller& caller) {
    (api.*method)(request, api.recorded(caller, request, finisher<Response>(reactor, response)), reactor->token());
  });
  return reactor;
}

// One override of a generated service: it does nothing but name the Api's method.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define KERF_UNARY(Rpc, method)                                                                               \
  grpc::ServerUnaryReactor* Rpc(Context* context, const ByteBuffer* request, ByteBuffer* response) override { \
    return answer(api_, &api::Api::method, context, request, response);                                       \
  }
// NOLINTEND(bugprone-macro-parentheses)

using RawSheets = RawService<
    v1::SheetService::Service, v1::SheetService::WithRawCallbackMethod_CreateSheet,
    v1::SheetService::WithRawCallbackMethod_GetSheet, v1::SheetService::WithRawCallbackMethod_ListSheets,
    v1::SheetService::WithRawCallbackMethod_DeleteSheet, v1::SheetService::WithRawCallbackMethod_PauseSheet,
    v1::SheetService::WithRawCallbackMethod_ResumeSheet, v1::SheetService::WithRawCallbackMethod_StepSheet,
    v1::SheetService::WithRawCallbackMethod_StepSheets, v1::SheetService::WithRawCallbackMethod_ResetSheet,
    v1::SheetService::WithRawCallbackMethod_SetSheetSpeed, v1::SheetService::WithRawCallbackMethod_ExportSheet,
    v1::SheetService::WithRawCallbackMethod_GetSheetState, v1::SheetService::WithRawCallbackMethod_AnalyzeSheet,
    v1::SheetService::WithRawCallbackMethod_SaveState, v1::SheetService::WithRawCallbackMethod_RestoreState,
    v1::SheetService::WithRawCallbackMethod_ListStates, v1::SheetService::WithRawCallbackMethod_DeleteState,
    v1::SheetService::WithRawCallbackMethod_UploadSheet, v1::SheetService::WithRawCallbackMethod_GetSheetRecording,
    v1::SheetService::WithRawCallbackMethod_ReplayRecording>::type;
class Sheets final : public RawSheets {
 public:
  Sheets(api::Api& api, TransferTiming timing) : api_(api), timing_(timing) {}
  KERF_UNARY(CreateSheet, create_sheet)
  KERF_UNARY(GetSheet, get_sheet)
  KERF_UNARY(ListSheets, list_sheets)
  KERF_UNARY(DeleteSheet, delete_sheet)
  KERF_UNARY(PauseSheet, pause_sheet)
  KERF_UNARY(ResumeSheet, resume_sheet)
  KERF_UNARY(StepSheet, step_sheet)
  KERF_UNARY(StepSheets, step_sheets)
  KERF_UNARY(ResetSheet, reset_sheet)
  KERF_UNARY(SetSheetSpeed, set_sheet_speed)
  KERF_UNARY(ExportSheet, export_sheet)
  KERF_UNARY(GetSheetState, get_sheet_state)
  KERF_UNARY(AnalyzeSheet, analyze_sheet)
  KERF_UNARY(SaveState, save_state)
  KERF_UNARY(RestoreState, restore_state)
  KERF_UNARY(ListStates, list_states)
  KERF_UNARY(DeleteState, delete_state)

  grpc::ServerReadReactor<ByteBuffer>* UploadSheet(Context* context, ByteBuffer* response) override {
    return receive_sheet(api_, timing_, *context, response);
  }
  grpc::ServerReadReactor<ByteBuffer>* ReplayRecording(Context* context, ByteBuffer* response) override {
    return receive_recording(api_, timing_, *context, response);
  }
  grpc::ServerWriteReactor<ByteBuffer>* GetSheetRecording(Context* context, const ByteBuffer* request) override {
    return send_recording(api_, timing_, *context, request);
  }

 private:
  api::Api& api_;
  const TransferTiming timing_;
};

using RawCuts =
    RawService<v1::CutService::Service, v1::CutService::WithRawCallbackMethod_CreateCut,
               v1::CutService::WithRawCallbackMethod_CreateCuts, v1::CutService::WithRawCallbackMethod_ListCuts,
               v1::CutService::WithRawCallbackMethod_CancelScheduledCuts, v1::CutService::WithRawCallbackMethod_UndoCut,
               v1::CutService::WithRawCallbackMethod_RedoCut, v1::CutService::WithRawCallbackMethod_ListPieces>::type;
class Cuts final : public RawCuts {
 public:
  explicit Cuts(api::Api& api) : api_(api) {}
  KERF_UNARY(CreateCut, create_cut)
  KERF_UNARY(CreateCuts, create_cuts)
  KERF_UNARY(ListCuts, list_cuts)
  KERF_UNARY(CancelScheduledCuts, cancel_scheduled_cuts)
  KERF_UNARY(UndoCut, undo_cut)
  KERF_UNARY(RedoCut, redo_cut)
  KERF_UNARY(ListPieces, list_pieces)

 private:
  api::Api& api_;
};

using RawFiles = RawService<v1::FileService::Service, v1::FileService::WithRawCallbackMethod_InspectMesh,
                            v1::FileService::WithRawCallbackMethod_InspectDrawing>::type;
class Files final : public RawFiles {
 public:
  explicit Files(api::Api& api) : api_(api) {}
  KERF_UNARY(InspectMesh, inspect_mesh)
  KERF_UNARY(InspectDrawing, inspect_drawing)

 private:
  api::Api& api_;
};

using RawInteraction =
    RawService<v1::InteractionService::Service, v1::InteractionService::WithRawCallbackMethod_GrabPoint,
               v1::InteractionService::WithRawCallbackMethod_DragPoint,
               v1::InteractionService::WithRawCallbackMethod_ReleasePoint,
               v1::InteractionService::WithRawCallbackMethod_SetSheetPins,
               v1::InteractionService::WithRawCallbackMethod_SetSheetGravity,
               v1::InteractionService::WithRawCallbackMethod_SetSheetWind,
               v1::InteractionService::WithRawCallbackMethod_SetSheetMaterial,
               v1::InteractionService::WithRawCallbackMethod_SetSheetSelfContact>::type;
class Interaction final : public RawInteraction {
 public:
  explicit Interaction(api::Api& api) : api_(api) {}
  KERF_UNARY(GrabPoint, grab_point)
  KERF_UNARY(DragPoint, drag_point)
  KERF_UNARY(ReleasePoint, release_point)
  KERF_UNARY(SetSheetPins, set_sheet_pins)
  KERF_UNARY(SetSheetGravity, set_sheet_gravity)
  KERF_UNARY(SetSheetWind, set_sheet_wind)
  KERF_UNARY(SetSheetMaterial, set_sheet_material)
  KERF_UNARY(SetSheetSelfContact, set_sheet_self_contact)

 private:
  api::Api& api_;
};

using RawRender = RawService<v1::RenderService::Service, v1::RenderService::WithRawCallbackMethod_RenderImage,
                             v1::RenderService::WithRawCallbackMethod_WatchImages>::type;
class Render final : public RawRender {
 public:
  Render(api::Api& api, StreamHosting& hosting) : api_(api), hosting_(hosting) {}
  KERF_UNARY(RenderImage, render_image)
  grpc::ServerBidiReactor<ByteBuffer, ByteBuffer>* WatchImages(Context* context) override {
    // Deletes itself in OnDone.
    return new TalkReactor(api_.watch_images(caller_of(api_, *context)), *context, hosting_);
  }

 private:
  api::Api& api_;
  StreamHosting& hosting_;
};

using RawServerInformation =
    RawService<v1::ServerService::Service, v1::ServerService::WithRawCallbackMethod_GetServerInfo>::type;
class ServerInformation final : public RawServerInformation {
 public:
  explicit ServerInformation(api::Api& api) : api_(api) {}
  KERF_UNARY(GetServerInfo, get_server_info)

 private:
  api::Api& api_;
};

using RawAccess = RawService<v1::AccessService::Service, v1::AccessService::WithRawCallbackMethod_GetAccess,
                             v1::AccessService::WithRawCallbackMethod_CreateLink>::type;
class Access final : public RawAccess {
 public:
  explicit Access(api::Api& api) : api_(api) {}
  KERF_UNARY(GetAccess, get_access)
  KERF_UNARY(CreateLink, create_link)

 private:
  api::Api& api_;
};

using RawStore = RawService<v1::StoreService::Service, v1::StoreService::WithRawCallbackMethod_GetStoreInfo,
                            v1::StoreService::WithRawCallbackMethod_PruneStore,
                            v1::StoreService::WithRawCallbackMethod_DeleteSetAsideSheet,
                            v1::StoreService::WithRawCallbackMethod_BackupStore>::type;
class Store final : public RawStore {
 public:
  explicit Store(api::Api& api) : api_(api) {}
  KERF_UNARY(GetStoreInfo, get_store_info)
  KERF_UNARY(PruneStore, prune_store)
  KERF_UNARY(DeleteSetAsideSheet, delete_set_aside_sheet)
  KERF_UNARY(BackupStore, backup_store)

 private:
  api::Api& api_;
};

#undef KERF_UNARY

}  // namespace

std::vector<NamedService> make_services(api::Api& api, TransferTiming timing, StreamHosting& hosting) {
  std::vector<NamedService> services;
  services.push_back({v1::SheetService::service_full_name(), std::make_unique<Sheets>(api, timing)});
  services.push_back({v1::CutService::service_full_name(), std::make_unique<Cuts>(api)});
  services.push_back({v1::FileService::service_full_name(), std::make_unique<Files>(api)});
  services.push_back({v1::InteractionService::service_full_name(), std::make_unique<Interaction>(api)});
  services.push_back({v1::StreamService::service_full_name(), make_stream_service(api, hosting)});
  services.push_back({v1::RenderService::service_full_name(), std::make_unique<Render>(api, hosting)});
  services.push_back({v1::ServerService::service_full_name(), std::make_unique<ServerInformation>(api)});
  services.push_back({v1::StoreService::service_full_name(), std::make_unique<Store>(api)});
  services.push_back({v1::AccessService::service_full_name(), std::make_unique<Access>(api)});
  return services;
}

}  // namespace kerf::rpc
