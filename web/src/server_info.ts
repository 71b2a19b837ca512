import { call } from './api';
import { ServerService } from './gen/kerf/v1/server_pb';
import type { ServerInfo } from './gen/kerf/v1/server_pb';

let asked: Promise<ServerInfo> | undefined;

/**
 * Materials and limits of this server, asked for once.
 * @throws ApiError, and the next call asks again
 */
export function serverInfo(): Promise<ServerInfo> {
  asked ??= call(ServerService.method.getServerInfo, {}).catch((error: unknown) => {
    asked = undefined;
    throw error;
  });
  return asked;
}
