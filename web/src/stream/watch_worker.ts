import type { FromWorker, Port, ToWorker } from './watch_messages';
import { WatchService } from './watch_service';

new WatchService(self as unknown as Port<FromWorker, ToWorker>);
