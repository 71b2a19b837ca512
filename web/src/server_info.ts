import { call } from './api';
import { ServerService } from './gen/kerf/v1/server_pb';
import type { ServerInfo } from './gen/kerf/v1/server_pb';

let asked: Promise<ServerInfo> | undefined;

/**
 * Returns materials and limits of this server, which is asked once.
 * @throws ApiError if that fails; the next call then asks again
 */
export function serverInfo(): Promise<ServerInfo> {
  asked ??= call(ServerService.method.getServerInfo, {}).catch((error: unknown) => {
    asked = undefined;
    throw error;
  });
  return asked;
}
