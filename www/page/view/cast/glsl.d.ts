/** Texts of shaders, as Vite has them. */
declare module '*.glsl?raw' {
  const text: string;
  export default text;
}
