"""Motion of a stiff chain in 90 digits: writes data/reference/motion_stiff_chain.json. Run from the root of the repository."""
import json
from mpmath import mp, mpf, matrix, expm, cos, sin, diag
mp.dps=90
def chain(J,k,c,drag,torque,q0,v0,times):
    n=len(J)
    A=matrix(2*n+2,2*n+2)
    for i in range(n):
        A[i,n+i]=1
        A[n+i,n+i]-=mpf(drag)
    for b,(kk,cc) in enumerate(zip(k,c)):
        i,j=b,b+1
        for (r,s) in ((i,1),(j,-1)):
            for (col,t) in ((j,1),(i,-1)):
                A[n+r,col]+=s*t*mpf(kk)/mpf(J[r]); A[n+r,n+col]+=s*t*mpf(cc)/mpf(J[r])
    (at,amp,om,ph)=torque
    A[n+at,2*n]=mpf(amp)/mpf(J[at])
    A[2*n,2*n+1]=-mpf(om); A[2*n+1,2*n]=mpf(om)
    out={}
    for t in times:
        y=matrix(2*n+2,1)
        for i in range(n): y[i]=mpf(q0[i]); y[n+i]=mpf(v0[i])
        y[2*n]=cos(mpf(ph)); y[2*n+1]=sin(mpf(ph))
        # scaled: squaring by hand
        m=A*mpf(t)
        s=60
        E=expm(m/2**s,method='taylor')
        # E = I + D, square D: (I+D)^2 = I + 2D + D^2
        I=mp.eye(2*n+2); D=E-I
        for _ in range(s): D=2*D+D*D
        y=(I+D)*y
        out[str(t)]=[mp.nstr(y[i],17) for i in range(2*n)]
    return out
J=[1.0,0.001,2.0,0.01,5.0,0.0001]
k=[1e9,0.1,1e6,1e3,1e8]
q0=[0.0,0.001,0.0,-0.002,0.003,0.0]; v0=[0.0,0.0,1.0,0.0,-0.5,0.0]
tq=(0,3.0,2.5,0.5)
d={"source":"matrix exponential of the state matrix with its torque in 90-digit arithmetic (mpmath), squared as 2D + D²",
 "model":"chain of six discs J_kg_m2 with springs k between neighbours and dampers c; drag times the inertia on each disc; torque a cos(w t + phi) on the first","J_kg_m2":J,"k_Nm_per_rad":k,"start_q":q0,"start_v":v0,"torque":{"amplitude_Nm":3.0,"omega_rad_s":2.5,"phase_rad":0.5}}
cases=[]
for name,c,drag in (("undamped",[0]*5,0.0),("drag",[0]*5,0.3),("dampers",[1e-2,1e-4,5.0,1e-3,2e-3],0.0)):
    f=lambda r:{kk:[float(x) for x in v] for kk,v in r.items()}
    cases.append({"name":name,"c_Nms_per_rad":c,"drag_per_s":drag,"y_at_s":f(chain(J,k,c,drag,tq,q0,v0,[0.5,8.0]))})
d["cases"]=cases
json.dump(d,open('data/reference/motion_stiff_chain.json','w'),indent=1)
