import type { FromReplay, ToReplay } from './replay_messages';
import { ReplayService } from './replay_service';
import type { Port } from './watch_messages';

new ReplayService(self as unknown as Port<FromReplay, ToReplay>);
