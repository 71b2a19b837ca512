import { defineConfig } from 'vitest/config';
import { precompress } from './precompress';

// `npm run dev` serves the viewer with hot reload and passes calls and the stream on to a running kerfd.
const kerfd = process.env.KERF_HTTP ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: './',
  plugins: [{ name: 'kerf-precompress', apply: 'build', writeBundle: ({ dir }) => precompress(dir!) }],
  build: { target: 'es2022', outDir: 'dist', emptyOutDir: true, chunkSizeWarningLimit: 1200 },
  server: {
    proxy: {
      '^/kerf\\.v1\\.': { target: kerfd },
      '^/(sheets|recordings|login|logout)\\b': { target: kerfd },
      '/watch': { target: kerfd, ws: true },
      '/images': { target: kerfd, ws: true },
    },
  },
  test: {
    include: ['test/**/*.test.ts'],
    environment: 'node',
    isolate: false,
    setupFiles: 'test/leave_no_trace.ts',
  },
});
