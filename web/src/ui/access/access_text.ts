import { Scope } from '../../gen/kerf/v1/access_service_pb';

const kScopes: Record<Scope, string> = {
  [Scope.UNSPECIFIED]: 'nothing',
  [Scope.VIEW]: 'look only',
  [Scope.CUT]: 'look and cut',
  [Scope.ADMIN]: 'everything',
};

/** Describes rights: "look only". */
export function scopeText(scope: Scope): string {
  return kScopes[scope] ?? kScopes[Scope.UNSPECIFIED];
}

/** Formats a time, s since 1970: "3 May 2026, 14:05"; for 0, which stands for no end, "it is withdrawn". */
export function untilText(unixS: bigint): string {
  if (unixS === 0n) return 'it is withdrawn';
  return new Date(1000 * Number(unixS)).toLocaleString('en-GB', { dateStyle: 'medium', timeStyle: 'short' });
}
